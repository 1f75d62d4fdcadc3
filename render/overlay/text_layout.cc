#include "render/overlay/text_layout.h"

#include <algorithm>
#include <cmath>

namespace hpdm {
namespace {

constexpr int kBarWidth = 8;  // in units of half the text's size

class Page {
 public:
  Page(const GlyphAtlas& atlas, Palette palette, int width, int height)
      : atlas_(atlas), palette_(palette), width_(width), height_(height) {}

  int LineWidth(const StatusLine& line) const {
    return atlas_.Width(TextOf(line)) + (line.bar ? Gap() + BarWidth() : 0);
  }

  // Adds a line with its top left corner at (x, y).
  void AddLine(const StatusLine& line, int x, int y) {
    const int base = y + atlas_.ascent();
    // A dark edge keeps light text readable over the picture.
    AddText(TextOf(line), x + 1, base + 1, {0, 0, 0, 0.8f});
    const int end = AddText(TextOf(line), x, base, ColourOf(line.tone, palette_));
    if (!line.bar) return;
    const int left = end + Gap(), thickness = std::max(3, atlas_.pixels() / 2);
    const int top = base - thickness;
    AddRectangle(left, top, BarWidth(), thickness, {0.35f, 0.37f, 0.40f, 0.9f});
    AddRectangle(left + 1, top + 1, BarWidth() - 2, thickness - 2, {0.05f, 0.05f, 0.06f, 1});
    const int filled = static_cast<int>(std::lround(*line.bar * (BarWidth() - 2)));
    AddRectangle(left + 1, top + 1, filled, thickness - 2, BarColour(*line.bar, palette_));
  }

  void AddRectangle(int x, int y, int width, int height, const Eigen::Vector4f& colour) {
    if (width <= 0 || height <= 0) return;
    Add({x, y, width, height, 0, 0, 1, 1, colour});
  }

  // Adds a teacher's mark: four bars around a point, or a disc for a bleeding; its text to the right,
  // or to the left near the right edge.
  void AddMark(const StatusMark& mark) {
    const int x = static_cast<int>(std::lround(mark.x * width_));
    const int y = static_cast<int>(std::lround(mark.y * height_));
    const int radius = std::max(4, static_cast<int>(std::lround(mark.radius * height_)));
    if (mark.kind == PictureMark::Kind::kPoint) {
      const int thickness = std::max(2, atlas_.pixels() / 5), length = radius - radius / 3;
      for (const int grow : {1, 0}) {  // a dark edge first
        const TextColour colour =
            grow > 0 ? TextColour(0, 0, 0, 0.8f) : ColourOf(Tone::kWarning, palette_);
        const int half = thickness / 2 + grow, part = length + 2 * grow;
        AddRectangle(x - radius - grow, y - half, part, 2 * half, colour);
        AddRectangle(x + radius - length - grow, y - half, part, 2 * half, colour);
        AddRectangle(x - half, y - radius - grow, 2 * half, part, colour);
        AddRectangle(x - half, y + radius - length - grow, 2 * half, part, colour);
      }
    } else {
      const TextColour blood(0.45f, 0.01f, 0.02f, 0.92f);
      for (int row = -radius; row < radius; ++row) {
        const double across = std::sqrt(radius * radius - (row + 0.5) * (row + 0.5));
        const int half = static_cast<int>(std::lround(across));
        AddRectangle(x - half, y + row, 2 * half, 1, blood);
      }
    }
    const int beside = radius + Gap();
    const int text = LineWidth(mark.line);
    const bool fits = x + beside + text <= width_;
    AddLine(mark.line, fits ? x + beside : x - beside - text, y - atlas_.line_height() / 2);
  }

  // Adds lines from the top down at the left or right edge.
  void AddBlock(const std::vector<StatusLine>& lines, bool right, int top) {
    for (const StatusLine& line : lines) {
      AddLine(line, right ? width_ - Margin() - LineWidth(line) : Margin(), top);
      top += atlas_.line_height();
    }
  }

  // Adds centred lines on a dark panel, a tenth of the height from the top.
  void AddAlarms(const std::vector<StatusLine>& lines) { AddCentred(lines, height_ / 10); }

  // The same, a twentieth of the height from the bottom.
  void AddGuidance(const std::vector<StatusLine>& lines) {
    AddCentred(lines, height_ - height_ / 20 - BlockHeight(lines));
  }

  void AddCentred(const std::vector<StatusLine>& lines, int y) {
    if (lines.empty()) return;
    int width = 0;
    for (const StatusLine& line : lines) width = std::max(width, LineWidth(line));
    const int pad = Gap();
    AddRectangle((width_ - width) / 2 - pad, y - pad, width + 2 * pad, BlockHeight(lines) + 2 * pad,
                 {0.03f, 0.03f, 0.04f, 0.82f});
    for (const StatusLine& line : lines) {
      AddLine(line, (width_ - LineWidth(line)) / 2, y);
      y += atlas_.line_height();
    }
  }

  // Adds a dark panel in the middle with a list of keys in two columns, or a short message.
  void AddBanner(const std::vector<StatusLine>& lines) {
    if (lines.empty()) return;
    int key_column = 0, text_column = 0;
    for (const StatusLine& line : lines) {
      if (!line.key.empty()) key_column = std::max(key_column, atlas_.Width(line.key) + 2 * Gap());
    }
    for (const StatusLine& line : lines) {
      text_column = std::max(text_column, LineWidth(line) - (line.key.empty() ? key_column : 0));
    }
    const int width = key_column + text_column, height = BlockHeight(lines);
    const int pad = atlas_.pixels(), x = (width_ - width) / 2;
    int y = (height_ - height) / 2;
    AddRectangle(x - pad, y - pad, width + 2 * pad, height + 2 * pad, {0.03f, 0.03f, 0.04f, 0.82f});
    for (const StatusLine& line : lines) {
      if (!line.key.empty()) AddLine({line.key, Tone::kWarning}, x, y);
      const int left = key_column == 0    ? (width_ - LineWidth(line)) / 2
                       : line.key.empty() ? x
                                          : x + key_column;
      AddLine(line, left, y);
      y += atlas_.line_height();
    }
  }

  int Margin() const { return atlas_.pixels() / 2; }
  int BlockHeight(const std::vector<StatusLine>& lines) const {
    return static_cast<int>(lines.size()) * atlas_.line_height();
  }
  std::vector<TextQuad> Take() { return std::move(quads_); }

 private:
  // Colour is not the only sign of an alarm.
  std::string TextOf(const StatusLine& line) const {
    const bool marked = palette_ == Palette::kColourBlind && line.tone == Tone::kAlarm;
    return marked ? "! " + line.text : line.text;
  }
  int Gap() const { return atlas_.pixels() / 2; }
  int BarWidth() const { return kBarWidth * atlas_.pixels() / 2; }

  // Returns the pen's place after the text.
  int AddText(const std::string& text, int x, int base, const Eigen::Vector4f& colour) {
    for (const char32_t code : CodePoints(text)) {
      const Glyph& glyph = atlas_.At(code);
      if (glyph.width > 0) {
        Add({x + glyph.left, base - glyph.top, glyph.width, glyph.height, glyph.x, glyph.y,
             glyph.width, glyph.height, colour});
      }
      x += glyph.advance;
    }
    return x;
  }

  void Add(const TextQuad& quad) {
    const bool inside = quad.x >= 0 && quad.y >= 0 && quad.x + quad.width <= width_ &&
                        quad.y + quad.height <= height_;
    const bool shapeless = quad.atlas_x == 0 && quad.atlas_y == 0;
    if (inside) {
      quads_.push_back(quad);
    } else if (shapeless) {  // a rectangle is cut, a character is omitted
      TextQuad cut = quad;
      cut.x = std::max(quad.x, 0);
      cut.y = std::max(quad.y, 0);
      cut.width = std::min(quad.x + quad.width, width_) - cut.x;
      cut.height = std::min(quad.y + quad.height, height_) - cut.y;
      if (cut.width > 0 && cut.height > 0) quads_.push_back(cut);
    }
  }

  const GlyphAtlas& atlas_;
  Palette palette_;
  int width_;
  int height_;
  std::vector<TextQuad> quads_;
};

}  // namespace

int TextPixels(int width, int height) {
  return std::clamp(std::min(width * 3 / 4, height) / 35, 9, 48);
}

std::vector<TextQuad> LayOut(const StatusText& text, const GlyphAtlas& atlas, int width, int height,
                             Palette palette) {
  Page page(atlas, palette, width, height);
  const int margin = page.Margin();
  for (const StatusMark& mark : text.marks) page.AddMark(mark);
  page.AddBlock(text.loops, false, margin);
  page.AddBlock(text.state, true, margin);
  std::array<int, 2> bottoms{height - margin, height - margin};  // left and right
  for (std::size_t tool = 0; tool < text.tools.size(); ++tool) {
    int& bottom = bottoms[text.on_right[tool] ? 1 : 0];
    bottom -= page.BlockHeight(text.tools[tool]);
    page.AddBlock(text.tools[tool], text.on_right[tool], bottom);
  }
  page.AddAlarms(text.alarms);
  page.AddGuidance(text.guidance);
  page.AddBanner(text.banner);
  return page.Take();
}

}  // namespace hpdm
