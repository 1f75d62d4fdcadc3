#include "tools/report/metrics/metric_definitions.h"

#include <algorithm>
#include <numbers>
#include <string_view>

namespace hpdm {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

constexpr MetricDefinition kDefinitions[] = {
    {"time_s", "Time", "s", 1, "%.1f",
     "Time with a known motion of the hand, without pauses, gaps in the log and a lost device.",
     "Cotin 2002", Better::kLower},
    {"path_length_m", "Path length", "m", 1, "%.3f",
     "Length of the path of the instrument's tip, after smoothing at 10 Hz.", "Cotin 2002",
     Better::kLower},
    {"angular_path_rad", "Angular path", "\u00b0", kDegrees, "%.0f",
     "Sum of the angles by which the shaft turned about the trocar, up, down and sideways.", "",
     Better::kLower},
    {"roll_path_rad", "Roll", "\u00b0", kDegrees, "%.0f",
     "Sum of the angles by which the instrument turned about its own shaft.", "Cotin 2002",
     Better::kLower},
    {"insertion_path_m", "Depth path", "m", 1, "%.3f",
     "Path of the tip along the shaft, in and out. It is large if the user searches for depth.",
     "Cotin 2002; Chmarra 2010", Better::kLower},
    {"economy_of_motion", "Economy of motion", "%", 100, "%.0f",
     "Straight distance from the start to the end of each movement over its path length, for all "
     "movements together. 100 %: only straight lines; a task that needs curves has less.",
     "Chmarra 2008", Better::kHigher},
    {"movements", "Movements", "", 1, "%.0f",
     "Number of times that the tip was faster than 5 mm/s for at least 0.1 s and reached 10 mm/s.",
     "Dosis 2005", Better::kLower},
    {"mean_speed_m_per_s", "Mean speed", "mm/s", 1000, "%.1f", "Path length over time.",
     "Oropesa 2013", Better::kNeither},
    {"peak_speed_m_per_s", "Peak speed", "mm/s", 1000, "%.0f",
     "Largest speed of the tip, after smoothing.", "", Better::kNeither},
    {"smoothness_sparc", "Smoothness (SPARC)", "", 1, "%.2f",
     "Spectral arc length of the speed, median over the movements of at most 10 s. Closer to 0 is "
     "smoother; an even movement without a stop has about -1.4, whatever its size and duration.",
     "Balasubramanian 2015", Better::kHigher},
    {"idle_s", "Idle time", "s", 1, "%.1f", "Time with the tip slower than 5 mm/s.", "Oropesa 2013",
     Better::kLower},
    {"advances", "Advances", "", 1, "%.0f",
     "Number of ways of at least 10 mm along the shaft into the body.", "", Better::kNeither},
    {"overshoots", "Overshoots", "", 1, "%.0f",
     "Advances through the air of which at least 3 mm, but at most half, were taken back at once.",
     "Vassiliou 2005", Better::kLower},
    {"contact_time_s", "Contact time", "s", 1, "%.1f", "Time with tissue at the tip.", "",
     Better::kNeither},
    {"contacts", "Contacts", "", 1, "%.0f",
     "Number of times that the tip touched tissue. Interruptions of at most 50 ms do not count.",
     "", Better::kNeither},
    {"forces_off_s", "Contact without forces", "s", 1, "%.2f",
     "Time with tissue at the tip while forces were switched off. The force figures exclude it.",
     "", Better::kNeither},
    {"forces_clamped_s", "Contact beyond the device", "s", 1, "%.2f",
     "Time with more force from the tissue than the device can display. The force figures have the "
     "displayed force.",
     "", Better::kLower},
    {"peak_force_N", "Peak force", "N", 1, "%.2f",
     "Largest force of the tissue on the hand, as the device displays it.",
     "Horeman 2010; Trejos 2014", Better::kLower},
    {"mean_force_N", "Mean force", "N", 1, "%.2f",
     "Mean force on the hand over the contact time, except while forces were switched off.",
     "Horeman 2010; Trejos 2014", Better::kLower},
    {"over_limit_s", "Time above the limit", "s", 1, "%.2f",
     "Time with a force above this session's limit of %LIMIT%.", "Rodrigues 2012", Better::kLower},
    {"over_limit_count", "Times above the limit", "", 1, "%.0f",
     "Number of times that the force rose above this session's limit of %LIMIT%.", "Rodrigues 2012",
     Better::kLower},
    {"force_impulse_Ns", "Force impulse", "N s", 1, "%.1f", "Integral of the force over time.",
     "Trejos 2014", Better::kLower},
    {"mean_force_rate_N_per_s", "Mean force rate", "N/s", 1, "%.2f",
     "Mean rate of change of the force, in size or direction, while there is a force (smoothed at "
     "10 Hz).",
     "Horeman 2012; Trejos 2014", Better::kLower},
    {"peak_force_rate_N_per_s", "Peak force rate", "N/s", 1, "%.1f",
     "Largest rate of change of the force (smoothed at 10 Hz).", "Horeman 2012; Trejos 2014",
     Better::kLower},
    {"deepest_press_m", "Deepest press", "mm", 1000, "%.1f",
     "Largest depth of the tip below the undisturbed surface, without the time of unknown depth.",
     "", Better::kLower},
    {"over_depth_s", "Time too deep", "s", 1, "%.2f",
     "Time with the tip deeper than this session's limit of %DEPTH_LIMIT%.", "", Better::kLower},
    {"over_depth_count", "Times too deep", "", 1, "%.0f",
     "Number of times that the tip went deeper than this session's limit of %DEPTH_LIMIT%.", "",
     Better::kLower},
    {"slips", "Slips", "", 1, "%.0f",
     "Number of times that tissue slipped in the jaws. Rests of at most 0.25 s do not count.", "",
     Better::kLower},
    {"depth_unknown_s", "Depth unknown", "s", 1, "%.2f",
     "Time of contact in which tissue had jumped, so that its surface says nothing "
     "about the tip. It does not count for depths.",
     "", Better::kNeither},
    {"device_lost_s", "Device lost", "s", 1, "%.2f",
     "Time without a usable pose from the device. It counts neither as movement nor as rest.", "",
     Better::kNeither},
};

constexpr MetricSource kSources[] = {
    {"Cotin 2002",
     "S. Cotin, N. Stylopoulos, M. Ottensmeyer, P. Neumann, D. Rattner, S. Dawson: Metrics for "
     "laparoscopic skills trainers: the weakest link! MICCAI 2002, LNCS 2488, 35-43."},
    {"Dosis 2005",
     "A. Dosis et al.: Synchronized video and motion analysis for the assessment of procedures in "
     "the operating theater. Archives of "
     "Surgery 140 (2005), 293-299. (Counting movements by speed; the thresholds are ours.)"},
    {"Chmarra 2008",
     "M. K. Chmarra, F. W. Jansen, C. A. Grimbergen, J. Dankelman: Retracting and seeking "
     "movements "
     "during laparoscopic goal-oriented movements. Is the shortest path length optimal? Surgical "
     "Endoscopy 22 (2008), 943-949. (Path compared with the straight line, which is not an ideal "
     "in "
     "itself; the sum over movements is our own.)"},
    {"Chmarra 2010",
     "M. K. Chmarra, S. Klein, J. C. F. de Winter, F. W. Jansen, J. Dankelman: Objective "
     "classification of residents based on their psychomotor laparoscopic skills. Surgical "
     "Endoscopy "
     "24 (2010), 1031-1039."},
    {"Oropesa 2013",
     "I. Oropesa, M. K. Chmarra, P. S\u00e1nchez-Gonz\u00e1lez, P. Lamata, S. P. Rodrigues, S. "
     "Enciso, F. M. "
     "S\u00e1nchez-Margallo, F. W. Jansen, J. Dankelman, E. J. G\u00f3mez: Relevance of "
     "motion-related "
     "assessment metrics in laparoscopic surgery. Surgical Innovation 20 (2013), 299-312. (Idle "
     "time "
     "and mean speed; the threshold is ours.)"},
    {"Balasubramanian 2015",
     "S. Balasubramanian, A. Melendez-Calderon, A. Roby-Brami, E. Burdet: On the analysis of "
     "movement "
     "smoothness. Journal of NeuroEngineering and Rehabilitation 12 (2015), 112."},
    {"Horeman 2010",
     "T. Horeman, S. P. Rodrigues, F. W. Jansen, J. Dankelman, J. J. van den Dobbelsteen: Force "
     "measurement platform for training and assessment of laparoscopic skills. Surgical Endoscopy "
     "24 "
     "(2010), 3102-3108."},
    {"Horeman 2012",
     "T. Horeman, S. P. Rodrigues, F. W. Jansen, J. Dankelman, J. J. van den Dobbelsteen: Force "
     "parameters for skills assessment in laparoscopy. IEEE Transactions on Haptics 5 (2012), "
     "312-322."},
    {"Rodrigues 2012",
     "S. P. Rodrigues, T. Horeman, J. Dankelman, J. J. van den Dobbelsteen, F. W. Jansen: Suturing "
     "intraabdominal organs: when do we cause tissue damage? Surgical Endoscopy 26 (2012), doi "
     "10.1007/s00464-011-1986-5. (Forces that tissues bear; the trainer sets the limit.)"},
    {"Vassiliou 2005",
     "M. C. Vassiliou, L. S. Feldman, C. G. Andrew, S. Bergman, K. Leffondr\u00e9, D. Stanbridge, "
     "G. "
     "M. Fried: A global assessment tool for evaluation of intraoperative laparoscopic skills. "
     "American Journal of Surgery 190 (2005), 107-113. (The domains, and that overshooting shows "
     "depth perception; every threshold is ours.)"},
    {"Trejos 2014",
     "A. L. Trejos, R. V. Patel, R. A. Malthaner, C. M. Schlachta: Development of force-based "
     "metrics "
     "for skills assessment in minimally invasive surgery. Surgical Endoscopy 28 (2014), "
     "2106-2119."},
};

}  // namespace

std::span<const MetricDefinition> MetricDefinitions() { return kDefinitions; }

const MetricDefinition* FindMetric(const std::string& key) {
  const auto* found = std::find_if(std::begin(kDefinitions), std::end(kDefinitions),
                                   [&key](const MetricDefinition& definition) {
                                     return std::string_view(definition.key) == key;
                                   });
  return found == std::end(kDefinitions) ? nullptr : found;
}

std::span<const MetricSource> MetricSources() { return kSources; }

}  // namespace hpdm
