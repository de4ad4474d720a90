// SPDX-License-Identifier: MIT
// Which camera of a source is which camera of the rig.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace glint {

/// Runs of digits compare as numbers: cam2 before cam10.
bool natural_less(std::string_view a, std::string_view b) noexcept;

/// For each wanted name its index in `found`; all of `found`, in their order, if nothing is wanted. Throws
/// Error that lists both sides if a wanted name was not found, a name occurs twice, or there are none or too
/// many cameras. `where` names the source in the message.
std::vector<std::size_t> select_cameras(const std::vector<std::string>& found,
                                        const std::vector<std::string>& wanted, const std::string& where);

/// "a, b, c"
std::string join_names(const std::vector<std::string>& names);

}  // namespace glint
