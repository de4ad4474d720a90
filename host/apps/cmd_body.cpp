// SPDX-License-Identifier: MIT
// glint body learn | check: rigid bodies out of a recording, and whether they can be told apart.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "host/apps/commands.hpp"
#include "host/apps/recorded_tracks.hpp"
#include "host/base/error.hpp"
#include "host/body/confusions.hpp"
#include "host/config/bodies_file.hpp"

namespace glint::apps {
namespace {

struct LearnArguments {
  std::filesystem::path recorded, out;
  std::string names;
  bool force = false;
};

struct CheckArguments {
  std::filesystem::path file;
  double tolerance_m = kConfusionTolerance_m;
  bool all = false;
};

/// Confusions that matter while at most one marker is hidden come first; of the others `all` decides.
void print_confusions(const std::vector<BodyModel>& bodies, double tolerance_m, bool all) {
  std::size_t weak = 0, told = 0;
  for (const Confusion& confusion : find_confusions(bodies, tolerance_m)) {
    if (!all && !confusion.whole && !confusion.nearly) {
      ++weak;
      continue;
    }
    ++told;
    std::cout << (confusion.whole    ? "confusable: "
                  : confusion.nearly ? "nearly confusable: "
                                     : "partly: ")
              << describe(confusion, bodies) << "\n";
  }
  if (told == 0)
    std::cout << "no body can be taken for another, or for itself turned, with a marker hidden\n";
  if (weak > 0)
    std::cout << weak << " further " << (weak == 1 ? "likeness" : "likenesses")
              << " of three or more markers, which matter only while the others are hidden: see --all\n";
}

void learn(const LearnArguments& arguments) {
  if (!arguments.force && std::filesystem::exists(arguments.out))
    throw Error(arguments.out.string() + ": exists; --force replaces it");
  const std::vector<RecordedTick> ticks = read_recorded_tracks(arguments.recorded);
  const Learnt learnt = learn_bodies(ticks);
  if (learnt.bodies.empty()) {
    std::string why;
    for (const std::string& remark : learnt.remarks) why += (why.empty() ? "" : "; ") + remark;
    throw Error(arguments.recorded.string() + ": no body learnt: " + why);
  }
  std::vector<BodyModel> models;
  for (const LearntBody& body : learnt.bodies) models.push_back(body.model);
  std::istringstream names(arguments.names);
  std::size_t named = 0;
  for (std::string name; std::getline(names, name, ','); ++named) {
    if (named == models.size())
      throw UsageError("--names: more than the " + std::to_string(models.size()) +
                       " bodies that were learnt");
    models[named].name = name;
  }
  write_bodies(arguments.out, models, arguments.force);
  for (std::size_t k = 0; k < models.size(); ++k) {
    char line[160];
    std::snprintf(line, sizeof line, ": %zu markers, %.0f mm across, %zu frames, markers known to %.2f mm\n",
                  models[k].markers_in_body.size(), 1e3 * models[k].diameter_m(), learnt.bodies[k].frames,
                  1e3 * models[k].marker_sd_m);
    std::cout << models[k].name << line;
  }
  for (const std::string& remark : learnt.remarks) std::cout << "note: " << remark << "\n";
  print_confusions(models, kConfusionTolerance_m, false);
}

void check(const CheckArguments& arguments) {
  if (!(arguments.tolerance_m > 0.0)) throw UsageError("--tolerance must be > 0 (metres)");
  const std::vector<BodyModel> bodies = read_bodies(arguments.file);
  std::cout << arguments.file.string() << ": ok, " << bodies.size()
            << (bodies.size() == 1 ? " body\n" : " bodies\n");
  print_confusions(bodies, arguments.tolerance_m, arguments.all);
}

}  // namespace

void add_body(CLI::App& app) {
  CLI::App* body = app.add_subcommand("body", "rigid bodies: learn them from a recording, check them");
  body->require_subcommand(1);

  CLI::App* learn_command =
      body->add_subcommand("learn", "learn bodies from what glint track --output csv: wrote");
  const auto learn_arguments = std::make_shared<LearnArguments>();
  learn_command->add_option("recorded", learn_arguments->recorded, "CSV of tracks")
      ->type_name("FILE.csv")
      ->required();
  learn_command->add_option("--out", learn_arguments->out, "body file to write")
      ->type_name("FILE")
      ->required();
  learn_command
      ->add_option("--names", learn_arguments->names, "names, most markers first; default body1, body2, ...")
      ->type_name("A,B,...");
  learn_command->add_flag("--force", learn_arguments->force, "replace the file");
  learn_command->callback([learn_arguments] { learn(*learn_arguments); });

  CLI::App* check_command =
      body->add_subcommand("check", "which bodies of a file can be taken for each other");
  const auto check_arguments = std::make_shared<CheckArguments>();
  check_command->add_option("file", check_arguments->file, "body or rig file")->type_name("FILE")->required();
  check_command
      ->add_option("--tolerance", check_arguments->tolerance_m, "what the tracker cannot tell apart, metres")
      ->capture_default_str();
  check_command->add_flag("--all", check_arguments->all, "list likenesses of few markers, too");
  check_command->callback([check_arguments] { check(*check_arguments); });
}

}  // namespace glint::apps
