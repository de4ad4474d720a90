// SPDX-License-Identifier: MIT
// The subcommands of `glint`; each is defined in its cmd_NAME.cpp. A command reports failure by throwing
// glint::Error (exit code 1) or glint::UsageError (exit code 2).
#pragma once

#include <CLI/CLI.hpp>

namespace glint::apps {

void add_bench(CLI::App& app);
void add_body(CLI::App& app);
void add_calibrate(CLI::App& app);
void add_config(CLI::App& app);
void add_detect(CLI::App& app);
void add_devices(CLI::App& app);
void add_doctor(CLI::App& app);
void add_import(CLI::App& app);
void add_sim(CLI::App& app);
void add_sync(CLI::App& app);
void add_track(CLI::App& app);

}  // namespace glint::apps
