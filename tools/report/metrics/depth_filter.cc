#include "tools/report/metrics/depth_filter.h"

namespace hpdm {

bool DepthFilter::Add(double time, const ToolSample& tool) {
  const double moved = (tool.p_tip_W - p_tip_W_).norm();
  const double most = kJump + moved + kTissueSpeed * (time - time_);
  const bool jumps = begun_ && tool.depth - depth_ > most;
  if (jumped_ && tool.depth <= depth_before_ + kJump) jumped_ = false;
  if (jumps && !jumped_) {
    jumped_ = true;
    depth_before_ = depth_;
  }
  begun_ = true;
  time_ = time;
  depth_ = tool.depth;
  p_tip_W_ = tool.p_tip_W;
  return counts();
}

}  // namespace hpdm
