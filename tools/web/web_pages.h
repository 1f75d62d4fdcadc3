#pragma once

#include <string_view>

namespace hpdm {

/// The pages of tools/web/built, which the program carries with it.
std::string_view DashboardPage();
std::string_view ReportPage();

}  // namespace hpdm
