#include "render/overlay/font.h"

// The assembler copies the file: half a megabyte as a C array would take seconds to compile.
asm(".pushsection .rodata\n"
    ".balign 16\n"
    "hpdm_font_begin:\n"
    ".incbin \"" HPDM_FONT_FILE
    "\"\n"
    "hpdm_font_end:\n"
    ".popsection\n");

extern "C" {
extern const std::uint8_t hpdm_font_begin[] __attribute__((visibility("hidden")));
extern const std::uint8_t hpdm_font_end[] __attribute__((visibility("hidden")));
}

namespace hpdm {

std::span<const std::uint8_t> FontFile() { return {hpdm_font_begin, hpdm_font_end}; }

}  // namespace hpdm
