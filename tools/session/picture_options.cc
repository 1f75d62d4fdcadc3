#include "tools/session/picture_options.h"

#include <algorithm>
#include <map>
#include <string_view>

#include "engine/base/error.h"
#include "render/camera/laparoscope.h"
#include "render/overlay/view_settings.h"
#include "render/render_loop.h"
#include "tools/session/session.h"
#include "tools/shared/number_text.h"

namespace hpdm {

PictureSize ParsePictureSize(const std::string& text) {
  PictureSize size;
  const std::string_view sides = text;
  const std::size_t cross = std::min(sides.find('x'), sides.size());
  if (!ReadNumber(sides.substr(0, cross), &size.width) ||
      !ReadNumber(sides.substr(std::min(cross + 1, sides.size())), &size.height)) {
    throw InputError("--size " + text + ": is not WIDTHxHEIGHT; give 640x480, for example");
  }
  for (const int side : {size.width, size.height}) {
    if (side >= Laparoscope::kMinSide && side <= Laparoscope::kMaxSide) continue;
    throw InputError("--size " + text + ": is out of range; give " +
                     std::to_string(Laparoscope::kMinSide) + " to " +
                     std::to_string(Laparoscope::kMaxSide) + " pixels on a side");
  }
  return size;
}

const std::vector<std::string>& OverlayNames() {
  static const std::vector<std::string> kNames = {"force", "contacts", "lattice", "error", "text"};
  return kNames;
}

std::uint32_t OverlaysOf(const std::vector<std::string>& names) {
  static const std::map<std::string, std::uint32_t> kOverlays = {{"force", kOverlayForce},
                                                                 {"contacts", kOverlayContacts},
                                                                 {"lattice", kOverlayLattice},
                                                                 {"error", kOverlayError},
                                                                 {"text", kOverlayText}};
  std::uint32_t overlays = kOverlayNone;
  for (const std::string& name : names) overlays |= kOverlays.at(name);
  return overlays;
}

RenderOptions RenderOptionsOf(const std::string& size, const std::vector<std::string>& overlays,
                              const Session& session) {
  const PictureSize sides = ParsePictureSize(size);
  RenderOptions render;
  render.width = sides.width;
  render.height = sides.height;
  render.max_hz = session.scene().timing.render_hz;
  render.names = session.Names();
  render.attachments = session.AttachmentVisuals();
  render.ducts = session.DuctVisuals();
  render.background = session.Background();
  render.overlays = OverlaysOf(overlays);
  return render;
}

}  // namespace hpdm
