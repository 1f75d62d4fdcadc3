#pragma once

#include <cstdint>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace hpdm {

/// One glyph in the atlas, px. Text runs along a base line from a pen position (x, y down).
struct Glyph {
  int x = 0, y = 0;           ///< Top left corner in the atlas.
  int width = 0, height = 0;  ///< Nothing is drawn for an empty one.
  int left = 0, top = 0;      ///< Offset from the pen to the glyph's left edge, and from its top to
                              ///< the pen.
  int advance = 0;            ///< Offset to the next pen position.
};

/// The glyphs of one text size, rasterised once into one coverage map: ASCII, Latin-1 and a few
/// symbols. Only glyph_atlas.cc includes FreeType. Immutable.
class GlyphAtlas {
 public:
  /// `pixels`: the font's size, 6 to 200 px. Throws MachineError if FreeType fails.
  explicit GlyphAtlas(int pixels);

  int pixels() const { return pixels_; }            ///< The font's size.
  int line_height() const { return line_height_; }  ///< Distance between base lines, px.
  int ascent() const { return ascent_; }            ///< Height of a line above its base line.

  /// Returns the glyph of a code point, or the glyph of '?'.
  const Glyph& At(char32_t code) const;
  /// Returns the width of a text in UTF-8, px.
  int Width(std::string_view utf8) const;

  /// Coverage, 0 to 255, rows from the top down without padding. The pixel (0, 0) is fully covered,
  /// for plain rectangles.
  const std::vector<std::uint8_t>& coverage() const { return coverage_; }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  int pixels_;
  int line_height_ = 0;
  int ascent_ = 0;
  int width_ = 0;
  int height_ = 0;
  std::vector<std::uint8_t> coverage_;
  std::unordered_map<char32_t, Glyph> glyphs_;
};

/// Returns the code points of a text in UTF-8; each invalid byte becomes '?'.
std::vector<char32_t> CodePoints(std::string_view utf8);

}  // namespace hpdm
