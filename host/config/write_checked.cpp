// SPDX-License-Identifier: MIT
// Read back before it is written.
#include "host/config/write_checked.hpp"

#include "host/base/error.hpp"
#include "host/config/rig.hpp"
#include "host/files/text_file.hpp"

namespace glint {

void write_checked(const std::filesystem::path& path, const std::string& text,
                   const std::function<void(std::string_view, FileProblems&)>& parse,
                   const std::string& instead, bool force) {
  FileProblems problems(path);
  parse(text, problems);
  if (!problems.empty()) {
    std::string message = path.string() + ": not written, because it could not be read back:";
    for (const std::string& line : problems.lines()) message += "\n" + line;
    throw Error(message);
  }
  if (force && is_rig_file(path)) throw Error(path.string() + ": is a rig file, which " + instead);
  write_text_file(path, text, force);
}

}  // namespace glint
