// SPDX-License-Identifier: MIT
// Lists of CPUs as Linux writes them: "2,4-6".
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace glint {

/// In order, each once. Nothing if `text` is no such list ("" is one of no CPU).
std::optional<std::vector<unsigned>> parse_cpu_list(std::string_view text);
std::string cpu_list_text(const std::vector<unsigned>& cpus);

}  // namespace glint
