#pragma once

#include <cstddef>
#include <initializer_list>

#include "engine/organ_options.h"

namespace hpdm {

/// Returns the series of at most kMaxTerms terms.
inline PronySeries Prony(std::initializer_list<PronySeries::Term> terms) {
  PronySeries prony;
  for (const PronySeries::Term& term : terms) {
    prony.terms[static_cast<std::size_t>(prony.count++)] = term;
  }
  return prony;
}

}  // namespace hpdm
