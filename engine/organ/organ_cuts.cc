#include "engine/organ/organ_cuts.h"

#include <memory>
#include <utility>

#include "engine/base/error.h"
#include "engine/tissue/notch_finder.h"
#include "engine/tissue/support.h"

namespace hpdm {
namespace {

// True if more than half of a cut lies in fixed supports.
bool RunsAlongFixedSupport(const CutSurface& cut, const OrganOptions& organ, const Box& bounds) {
  double area = 0, held = 0;
  for (const CutSurface::Sample& sample : cut.samples()) {
    area += sample.area;
    for (const SupportOptions& support : organ.supports) {
      if (support.stiffness || !InRegion(support.region, bounds, sample.p_W)) continue;
      held += sample.area;
      break;
    }
  }
  return held > 0.5 * area;
}

CutSurface MakeCut(const CutOptions& options, const OrganOptions& organ, const SurfaceMesh& rest_W,
                   const Box& bounds, const OrientedBox& box_W) {
  CutSurface cut(box_W, options, rest_W);
  if (!RunsAlongFixedSupport(cut, organ, bounds)) return cut;
  throw InputError("organ \"" + organ.name + "\": cut[" + std::to_string(options.number) +
                   "]: runs along a fixed [[organ.support]], which holds both its sides; move it "
                   "or make the support smaller");
}

}  // namespace

CutSurfaces CutsOf(const OrganOptions& organ, const SurfaceMesh& rest_W, const Box& bounds,
                   const OrientedBox& box_W, double cell, std::vector<std::string>* warnings) {
  std::vector<CutSurface> cuts;
  for (const CutOptions& cut : organ.cuts) {
    cuts.push_back(MakeCut(cut, organ, rest_W, bounds, box_W));
  }
  if (TakesNotches(organ)) {
    for (const CutOptions& notch : FindNotches(rest_W, organ.name, cell)) {
      try {
        CutSurface cut = MakeCut(notch, organ, rest_W, bounds, box_W);
        if (cut.has_front()) cuts.push_back(std::move(cut));
      } catch (const InputError&) {
        warnings->push_back("organ \"" + organ.name +
                            "\": a narrow notch gets no functions of its own, so its sides move "
                            "together; give more cells");
      }
    }
  }
  if (cuts.empty()) return nullptr;
  return std::make_shared<const std::vector<CutSurface>>(std::move(cuts));
}

}  // namespace hpdm
