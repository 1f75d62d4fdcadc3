#include "render/overlay/glyph_atlas.h"

#include <ft2build.h>
#include FT_FREETYPE_H

#include <algorithm>
#include <memory>
#include <string>

#include "engine/base/check.h"
#include "engine/base/error.h"
#include "render/overlay/font.h"

namespace hpdm {
namespace {

constexpr int kGap = 1;  // px between glyphs

std::vector<char32_t> Characters() {
  std::vector<char32_t> characters;
  for (char32_t c = 0x20; c < 0x7f; ++c) characters.push_back(c);
  for (char32_t c = 0xa0; c < 0x100; ++c) characters.push_back(c);
  for (const char32_t c : {0x2013, 0x2212}) characters.push_back(c);  // dash, minus
  characters.push_back(0x25b8);                                       // small triangle to the right
  characters.push_back(0x25cf);                                       // black circle
  return characters;
}

void RequireFreeType(FT_Error error, const char* what) {
  if (error != 0) {
    throw MachineError(std::string("text on the picture: FreeType: ") + what + " failed (error " +
                       std::to_string(error) + "); reinstall libfreetype6");
  }
}

}  // namespace

GlyphAtlas::GlyphAtlas(int pixels) : pixels_(pixels) {
  HPDM_CHECK(pixels >= 6 && pixels <= 200);
  FT_Library library = nullptr;
  RequireFreeType(FT_Init_FreeType(&library), "the start");
  const std::unique_ptr<FT_LibraryRec_, decltype(&FT_Done_FreeType)> owned(library,
                                                                           FT_Done_FreeType);
  FT_Face face = nullptr;
  const auto file = FontFile();
  RequireFreeType(
      FT_New_Memory_Face(library, file.data(), static_cast<FT_Long>(file.size()), 0, &face),
      "reading the font");
  RequireFreeType(FT_Set_Pixel_Sizes(face, 0, static_cast<FT_UInt>(pixels)), "scaling the font");
  constexpr int kUnit = 64;  // FreeType counts in 64ths of a pixel
  line_height_ = static_cast<int>(face->size->metrics.height / kUnit);
  ascent_ = static_cast<int>(face->size->metrics.ascender / kUnit);

  // Fills rows of glyphs; the map is about as high as wide.
  width_ = 16 * pixels;
  int x = 1 + kGap, y = 0, row_height = 1;
  coverage_.assign(static_cast<std::size_t>(width_), 0);
  coverage_[0] = 255;
  for (const char32_t code : Characters()) {
    RequireFreeType(FT_Load_Char(face, code, FT_LOAD_RENDER), "drawing a character");
    const FT_GlyphSlotRec& slot = *face->glyph;
    const FT_Bitmap& bitmap = slot.bitmap;
    Glyph glyph;
    glyph.width = static_cast<int>(bitmap.width);
    glyph.height = static_cast<int>(bitmap.rows);
    glyph.left = slot.bitmap_left;
    glyph.top = slot.bitmap_top;
    glyph.advance = static_cast<int>(slot.advance.x / kUnit);
    if (x + glyph.width > width_) {
      x = 0;
      y += row_height + kGap;
      row_height = 0;
    }
    glyph.x = x;
    glyph.y = y;
    row_height = std::max(row_height, glyph.height);
    height_ = std::max(height_, y + std::max(row_height, 1));
    coverage_.resize(static_cast<std::size_t>(width_) * height_, 0);
    for (int row = 0; row < glyph.height; ++row) {
      const std::uint8_t* from = bitmap.buffer + static_cast<std::ptrdiff_t>(row) * bitmap.pitch;
      std::copy(from, from + glyph.width,
                coverage_.begin() + static_cast<std::ptrdiff_t>(y + row) * width_ + x);
    }
    x += glyph.width + kGap;
    glyphs_.emplace(code, glyph);
  }
}

const Glyph& GlyphAtlas::At(char32_t code) const {
  const auto found = glyphs_.find(code);
  return found != glyphs_.end() ? found->second : glyphs_.at('?');
}

int GlyphAtlas::Width(std::string_view utf8) const {
  int width = 0;
  for (const char32_t code : CodePoints(utf8)) width += At(code).advance;
  return width;
}

std::vector<char32_t> CodePoints(std::string_view utf8) {
  std::vector<char32_t> codes;
  for (std::size_t i = 0; i < utf8.size();) {
    const auto first = static_cast<unsigned char>(utf8[i]);
    const std::size_t length = first < 0x80   ? 1
                               : first < 0xc2 ? 0
                               : first < 0xe0 ? 2
                               : first < 0xf0 ? 3
                               : first < 0xf5 ? 4
                                              : 0;
    char32_t code = length == 1 ? first : first & (0x7fu >> length);
    bool valid = length > 0 && i + length <= utf8.size();
    for (std::size_t k = 1; valid && k < length; ++k) {
      const auto next = static_cast<unsigned char>(utf8[i + k]);
      valid = (next & 0xc0) == 0x80;
      code = code << 6 | (next & 0x3f);
    }
    codes.push_back(valid ? code : U'?');
    i += valid ? length : 1;
  }
  return codes;
}

}  // namespace hpdm
