#include "tools/session/trace_remark.h"

#include "engine/base/error.h"
#include "tools/shared/report_text.h"

namespace hpdm {

void RefuseWrongScale(const TraceFile& file, const TraceMotion& motion, double scale) {
  constexpr double kMaxSpan = 2;  // m
  if (file.place != TracePlace::kTip) return;
  Vector3d min = motion.places().front().values, max = min;
  for (const TraceMotion::Places::Knot& place : motion.places()) {
    min = min.cwiseMin(place.values);
    max = max.cwiseMax(place.values);
  }
  const double span = scale * (max - min).norm();
  if (span <= kMaxSpan) return;
  throw InputError(file.path +
                   Format(": the tip's places are %.3g m apart; give metres per unit of "
                          "the file as instrument.trace.scale: scale = 0.001 for "
                          "millimetres",
                          span));
}

std::string TraceRemark(const TraceFile& file, const TraceMotion& motion,
                        const TraceMapping& mapping, const TraceDevice& device, bool fitted) {
  std::string remark =
      Format("plays %.1f s, %zu rows", ToSeconds(device.duration()), file.rows.size());
  if (file.place == TracePlace::kTip) {
    const Vector3d& p = mapping.position_W;
    remark += Format(" (%zu places), up to %.3f m/s, file's origin at [%.4f, %.4f, %.4f]%s",
                     motion.places().size(), mapping.speed * mapping.scale * motion.fastest(),
                     p.x(), p.y(), p.z(), fitted ? " (fitted)" : "");
  } else if (file.place == TracePlace::kNone) {
    remark += ", the tip does not move";
  }
  if (const TraceMotion::Gaps gaps = motion.gaps(); gaps.count > 0) {
    remark += Format("; %zu gap%s, the longest %.2f s, bridged by a smooth motion", gaps.count,
                     gaps.count == 1 ? "" : "s", ToSeconds(gaps.longest_ns));
  }
  if (const double share = device.ClampedShare(); share > 0) {
    remark += Format(
        "; %.2g %% of the rows are outside the device's workspace and clamped; move the trace with "
        "instrument.trace",
        100 * share);
  }
  for (std::size_t i = 0; i < file.unread_columns.size(); ++i) {
    remark += (i == 0 ? "; not read: " : ", ") + file.unread_columns[i];
  }
  return remark + " [" + file.path + "]";
}

}  // namespace hpdm
