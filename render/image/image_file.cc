#include "render/image/image_file.h"

#include <png.h>

#include <cerrno>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

#include "engine/base/check.h"
#include "engine/base/error.h"

namespace hpdm {
namespace {

constexpr png_uint_32 kMaxSide = 16384;

void AppendBytes(png_structp png, png_bytep data, png_size_t size) {
  auto* bytes = static_cast<std::vector<std::uint8_t>*>(png_get_io_ptr(png));
  bytes->insert(bytes->end(), data, data + size);
}

/// libpng reports failure by longjmp, so this function has no object with a destructor.
bool EncodeRows(const Image& image, PngEffort effort, std::vector<std::uint8_t>* bytes,
                png_structp png, png_infop info) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_write_fn(png, bytes, AppendBytes, nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.width),
               static_cast<png_uint_32>(image.height), 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  const bool fast = effort == PngEffort::kFast;
  png_set_compression_level(png, fast ? 1 : 9);
  // One fixed filter: trying all five on every row costs more than it saves at the fast level.
  png_set_filter(png, PNG_FILTER_TYPE_BASE, fast ? PNG_FILTER_UP : PNG_ALL_FILTERS);
  png_write_info(png, info);
  for (int y = 0; y < image.height; ++y) png_write_row(png, image.At(0, y));
  png_write_end(png, info);
  return true;
}

}  // namespace

void EncodePng(const Image& image, std::vector<std::uint8_t>* bytes, PngEffort effort) {
  HPDM_CHECK(image.width > 0 && image.height > 0);
  bytes->clear();
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  // After these checks only memory can run out, which ends the program anyway.
  HPDM_CHECK(info != nullptr);
  const bool encoded = EncodeRows(image, effort, bytes, png, info);
  png_destroy_write_struct(&png, &info);
  HPDM_CHECK(encoded);
}

bool WriteBytes(const std::filesystem::path& file, const std::vector<std::uint8_t>& bytes,
                std::string* failure) {
  std::FILE* out = std::fopen(file.c_str(), "wb");
  int reason = out == nullptr ? errno : 0;
  if (out != nullptr) {
    if (std::fwrite(bytes.data(), 1, bytes.size(), out) != bytes.size()) reason = errno;
    // The system may report a failed write only on close.
    if (std::fclose(out) != 0 && reason == 0) reason = errno;
  }
  if (reason == 0) return true;
  // Removes the incomplete file, which also frees its space. A device file stays.
  std::error_code ignored;
  if (out != nullptr && std::filesystem::is_regular_file(file, ignored)) {
    std::filesystem::remove(file, ignored);
  }
  *failure = file.string() + ": cannot be written (" + std::strerror(reason) +
             "); choose a folder that exists, is writable and has space";
  return false;
}

void WritePng(const std::filesystem::path& file, const Image& image, PngEffort effort) {
  std::vector<std::uint8_t> bytes;
  EncodePng(image, &bytes, effort);
  std::string failure;
  if (!WriteBytes(file, bytes, &failure)) throw InputError(failure);
}

Image ReadPng(const std::filesystem::path& file) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  // Frees libpng's memory at every exit.
  const std::unique_ptr<png_image, void (*)(png_image*)> guard(&png, png_image_free);
  const auto fail = [&file](const std::string& reason) {
    throw InputError(file.string() + ": " + reason + "; give a readable PNG file");
  };
  if (!png_image_begin_read_from_file(&png, file.c_str())) fail(png.message);
  if (png.width > kMaxSide || png.height > kMaxSide) fail("more than 16,384 pixels on a side");
  png.format = PNG_FORMAT_RGB;
  Image image;
  image.width = static_cast<int>(png.width);
  image.height = static_cast<int>(png.height);
  image.rgb.resize(PNG_IMAGE_SIZE(png));
  const png_color black = {0, 0, 0};
  if (!png_image_finish_read(&png, &black, image.rgb.data(), 0, nullptr)) fail(png.message);
  return image;
}

}  // namespace hpdm
