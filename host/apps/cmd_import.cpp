// SPDX-License-Identifier: MIT
// glint import calibration FILE... --output FILE: other tools' calibrations to glint's file.
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "host/apps/commands.hpp"
#include "host/apps/utc_time.hpp"
#include "host/base/error.hpp"
#include "host/config/import_calibration.hpp"
#include "host/config/rig.hpp"

namespace glint::apps {
namespace {

struct Arguments {
  std::vector<std::filesystem::path> files;
  std::filesystem::path output;
  std::string format, unit, size, names;
  bool force = false;
};

std::optional<double> metres_per(const std::string& unit) {
  if (unit.empty()) return std::nullopt;
  if (unit == "mm") return 0.001;
  if (unit == "cm") return 0.01;
  if (unit == "m") return 1.0;
  if (unit == "inch") return 0.0254;
  throw UsageError("--unit " + unit + ": must be mm, cm, m or inch");
}

/// "1280x800"
void take_size(const std::string& text, ImportOptions& options) {
  if (text.empty()) return;
  const auto digits = [](const std::string& part) {
    return !part.empty() && part.size() <= 5 &&
           std::all_of(part.begin(), part.end(), [](char c) { return c >= '0' && c <= '9'; });
  };
  const auto cross = text.find('x');
  if (cross != std::string::npos && digits(text.substr(0, cross)) && digits(text.substr(cross + 1))) {
    options.width_px = static_cast<std::uint32_t>(std::stoul(text.substr(0, cross)));
    options.height_px = static_cast<std::uint32_t>(std::stoul(text.substr(cross + 1)));
    if (options.width_px > 0 && options.height_px > 0) return;
  }
  throw UsageError("--size " + text + ": must be WIDTHxHEIGHT in pixels, like 1280x800");
}

/// "north,east,south"
void take_names(const std::string& text, ImportOptions& options) {
  if (text.empty()) return;
  std::istringstream names(text + ",");
  for (std::string name; std::getline(names, name, ',');) options.names.push_back(name);
}

ImportOptions options_of(const Arguments& arguments) {
  ImportOptions options;
  if (!arguments.format.empty()) {
    const auto format = calibration_format_of(arguments.format);
    if (!format) {
      throw UsageError("--format " + arguments.format +
                       ": must be json, opencv, anipose, caliscope or openlpt");
    }
    options.format = *format;
  }
  options.metres_per_unit = metres_per(arguments.unit);
  take_names(arguments.names, options);
  take_size(arguments.size, options);
  return options;
}

/// Camera distances are what a person can check with a tape: a wrong unit or a pose read the wrong way round
/// shows.
void print_summary(const std::filesystem::path& output, const Calibration& calibration) {
  std::cout << "wrote " << output.string() << ": " << calibration.cameras.size()
            << (calibration.cameras.size() == 1 ? " camera\n" : " cameras\n");
  for (const CameraCalibration& camera : calibration.cameras) {
    std::cout << "  " << camera.name << "  " << camera.width_px << "x" << camera.height_px;
    if (&camera != &calibration.cameras.front()) {
      const Eigen::Vector3d from_first =
          camera.world_from_camera.translation - calibration.cameras.front().world_from_camera.translation;
      std::cout << "  " << from_first.norm() << " m from " << calibration.cameras.front().name;
    }
    std::cout << "\n";
  }
}

void run(const Arguments& arguments) {
  const ImportOptions options = options_of(arguments);
  std::vector<std::string> notes;
  Calibration calibration = import_calibration(arguments.files, options, &notes);
  calibration.made_at = utc_now();
  write_calibration(arguments.output, calibration, arguments.force);
  for (const std::string& note : notes) std::cerr << "note: " << note << "\n";
  print_summary(arguments.output, calibration);
}

}  // namespace

void add_import(CLI::App& app) {
  CLI::App* import = app.add_subcommand("import", "convert other tools' files");
  import->require_subcommand(1);
  CLI::App* calibration = import->add_subcommand(
      "calibration", "write a calibration file from one of OpenCV, aniposelib, caliscope, OpenLPT or JSON");
  const auto arguments = std::make_shared<Arguments>();
  calibration->add_option("files", arguments->files, "files to read, in the order of the cameras")
      ->required()
      ->type_name("FILE");
  calibration->add_option("-o,--output", arguments->output, "calibration file to write")
      ->required()
      ->type_name("FILE");
  calibration->add_flag("--force", arguments->force, "overwrite the output file");
  calibration->add_option("--format", arguments->format,
                          "json, opencv, anipose, caliscope or openlpt (default: by the content)");
  calibration->add_option("--unit", arguments->unit,
                          "mm, cm, m or inch: the files' unit of length, where they do not say it");
  calibration->add_option("--names", arguments->names, "camera names, as the image source calls them")
      ->type_name("NAME,...");
  calibration->add_option("--size", arguments->size, "image size, where the files do not say it")
      ->type_name("WIDTHxHEIGHT");
  calibration->callback([arguments] { run(*arguments); });
}

}  // namespace glint::apps
