#include "tools/web/web_pages.h"

// The assembler copies the files in: as string literals they would exceed what compilers promise.
#define HPDM_EMBED(symbol, file)                                                           \
  __asm__(".section .rodata\n.global " #symbol "_begin\n.global " #symbol "_end\n" #symbol \
          "_begin:\n.incbin \"" file "\"\n" #symbol                                        \
          "_end:\n"                                                                        \
          ".byte 0\n.previous\n");                                                         \
  extern "C" const char symbol##_begin[], symbol##_end[]

HPDM_EMBED(hpdm_dashboard_page, HPDM_WEB_FOLDER "/dashboard.html");
HPDM_EMBED(hpdm_report_page, HPDM_WEB_FOLDER "/report.html");

namespace hpdm {

std::string_view DashboardPage() { return {hpdm_dashboard_page_begin, hpdm_dashboard_page_end}; }
std::string_view ReportPage() { return {hpdm_report_page_begin, hpdm_report_page_end}; }

}  // namespace hpdm
