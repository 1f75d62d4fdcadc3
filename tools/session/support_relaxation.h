#pragma once

#include <optional>
#include <string>

#include "engine/organ.h"
#include "haptics/device/instrument_options.h"

namespace hpdm {

/// The error of supports with a stiffness in viscoelastic tissue. They relax with the tissue
/// (engine/README.md, section 4) although real ones may be elastic, so the organ is too stiff at
/// once: by this share of the stiffness that it has with elastic springs. Rigid supports and the
/// relaxed organ have no such error.
struct SupportRelaxation {
  double median = 0;    ///< Over the vertices.
  double greatest = 0;  ///< That 95 % of the vertices do not exceed.
};

/// Measures it under the instrument's tip at every vertex. Nothing for an organ that is elastic,
/// rigid or without a support with a stiffness. Set-up: builds and factorises the organ again.
std::optional<SupportRelaxation> MeasureSupportRelaxation(const OrganModel& organ,
                                                          const InstrumentOptions& instrument);

/// Returns one line for the user if `greatest` exceeds 10 %, else an empty string.
std::string SupportRemark(const std::string& organ, const SupportRelaxation& relaxation);

}  // namespace hpdm
