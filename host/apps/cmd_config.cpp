// SPDX-License-Identifier: MIT
// glint config --show | --check FILE: the effective settings, and whether a file is fit for use.
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include "host/apps/commands.hpp"
#include "host/base/error.hpp"
#include "host/config/rig.hpp"

namespace glint::apps {
namespace {

struct Arguments {
  bool show = false;
  std::filesystem::path rig, check;
};

void run(const Arguments& arguments) {
  if (arguments.show == !arguments.check.empty()) {
    throw UsageError("glint config: give either --show or --check FILE");
  }
  if (!arguments.check.empty()) {
    if (!arguments.rig.empty()) throw UsageError("glint config: --rig goes with --show");
    const Rig rig = read_rig(arguments.check);
    const std::size_t cameras = rig.calibration.cameras.size();
    std::cout << arguments.check.string() << ": ok, " << cameras
              << (cameras == 1 ? " camera\n" : " cameras\n");
    return;
  }
  std::cout << to_toml(arguments.rig.empty() ? Rig{} : read_rig(arguments.rig));
}

}  // namespace

void add_config(CLI::App& app) {
  CLI::App* config = app.add_subcommand("config", "show the effective settings or check a file");
  const auto arguments = std::make_shared<Arguments>();
  config->add_flag("--show", arguments->show, "print a rig file with every key; without --rig the defaults");
  config->add_option("--rig", arguments->rig, "rig or calibration file to show")->type_name("FILE");
  config->add_option("--check", arguments->check, "rig or calibration file to check: every problem is listed")
      ->type_name("FILE");
  config->callback([arguments] { run(*arguments); });
}

}  // namespace glint::apps
