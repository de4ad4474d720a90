// SPDX-License-Identifier: MIT
// `glint doctor`: what stops live capture on this computer, or makes it worse, and what to do about it.
#include <cstdio>
#include <iterator>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "gpu/detector.hpp"
#include "host/apps/commands.hpp"
#include "host/apps/live_cameras.hpp"
#include "host/apps/sync_board_list.hpp"
#include "host/apps/version.hpp"
#include "host/base/error.hpp"
#include "host/capture/v4l2/camera_list.hpp"
#include "host/config/rig.hpp"
#include "host/doctor/camera_checks.hpp"
#include "host/doctor/machine_checks.hpp"
#include "host/doctor/usb_checks.hpp"
#include "host/realtime/scheduler_calls.hpp"

namespace glint::apps {
namespace {

struct DoctorArguments {
  std::string rig_file;
  bool json = false;
};

void append(Findings& all, Findings more) {
  all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

/// The cameras that the rig file names; none, and a finding, if it names none.
std::vector<CameraRequest> wanted_cameras(const std::string& rig_file, Findings& findings) {
  if (rig_file.empty()) {
    findings.push_back({"rig", Verdict::Ok, "no rig file given", "--rig FILE also checks the rig's cameras"});
    return {};
  }
  const Rig rig = read_rig(rig_file);
  try {
    return live_options("", rig.rate_hz, rig, {}).cameras;
  } catch (const UsageError& error) {
    findings.push_back({"rig", Verdict::Problem, error.what(), "docs/rig-file.md, section [capture]"});
    return {};
  }
}

Findings examine(const DoctorArguments& a) {
  KernelCalls calls;
  KernelSchedulerCalls scheduler;
  const DeviceRoots roots;
  Findings findings;
  const CameraList list = list_cameras(calls, roots);
  append(findings, check_cameras(list, roots));
  const std::vector<CameraRequest> wanted = wanted_cameras(a.rig_file, findings);
  append(findings, check_wanted(calls, roots, wanted));
  append(findings, check_usb(list, roots, wanted));
  append(findings, check_hid(roots.dev));
  append(findings, check_sync_boards(kVersionNumber));
  std::string no_vulkan;
  const std::vector<gpu::DeviceInfo> devices = gpu::list_devices(&no_vulkan);
  findings.push_back(check_vulkan(devices, no_vulkan));
  append(findings, check_limits(scheduler));
  append(findings, check_processors(roots.sys, scheduler));
  append(findings, check_clocks(roots.sys));
  return findings;
}

const char* word(Verdict verdict) {
  switch (verdict) {
    case Verdict::Ok:
      return "ok";
    case Verdict::Warning:
      return "warning";
    case Verdict::Problem:
      break;
  }
  return "problem";
}

void print(const Findings& findings) {
  for (const Finding& finding : findings) {
    std::printf("%-8s %-12s %s\n", word(finding.verdict), finding.check.c_str(), finding.text.c_str());
    if (!finding.advice.empty()) std::printf("%-8s %-12s -> %s\n", "", "", finding.advice.c_str());
  }
}

void print_json(const Findings& findings, std::size_t problems) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const Finding& finding : findings) {
    all.push_back({{"check", finding.check},
                   {"verdict", word(finding.verdict)},
                   {"text", finding.text},
                   {"advice", finding.advice}});
  }
  const nlohmann::ordered_json json{{"problems", problems}, {"findings", std::move(all)}};
  std::printf("%s\n", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
}

void run(const DoctorArguments& a) {
  const Findings findings = examine(a);
  std::size_t problems = 0;
  for (const Finding& finding : findings) problems += finding.verdict == Verdict::Problem ? 1 : 0;
  if (a.json) {
    print_json(findings, problems);
  } else {
    print(findings);
  }
  std::fflush(stdout);
  if (problems > 0) {
    throw Error(problems == 1 ? "one problem stops live capture"
                              : std::to_string(problems) + " problems stop live capture");
  }
}

}  // namespace

void add_doctor(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("doctor", "Say what stops live capture here, and what to do about it");
  const auto a = std::make_shared<DoctorArguments>();
  command->add_option("--rig", a->rig_file,
                      "rig file: are its cameras there, and do they offer what it wants?");
  command->add_flag("--json", a->json, "as JSON");
  command->callback([a] { run(*a); });
}

}  // namespace glint::apps
