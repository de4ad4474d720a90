// SPDX-License-Identifier: MIT
// The `glint` command: subcommands, exit codes.
#include <csignal>
#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>

#include "host/apps/commands.hpp"
#include "host/apps/version.hpp"
#include "host/base/error.hpp"

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);  // a reader that goes away shows as a failed write, which has a message
  CLI::App app("glint tracks markers with synchronised cameras on any GPU", "glint");
  app.set_version_flag("--version", std::string("glint ") + glint::apps::kVersion);
  app.require_subcommand(1);
  glint::apps::add_track(app);
  glint::apps::add_detect(app);
  glint::apps::add_calibrate(app);
  glint::apps::add_body(app);
  glint::apps::add_devices(app);
  glint::apps::add_doctor(app);
  glint::apps::add_sync(app);
  glint::apps::add_bench(app);
  glint::apps::add_sim(app);
  glint::apps::add_import(app);
  glint::apps::add_config(app);
  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::Success& e) {
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    std::fprintf(
        stderr, "glint: %s\nglint: see glint%s --help\n", e.what(),
        app.get_subcommands().empty() ? "" : (" " + app.get_subcommands().front()->get_name()).c_str());
    return 2;
  } catch (const glint::UsageError& e) {
    std::fprintf(stderr, "glint: %s\n", e.what());
    return 2;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "glint: %s\n", e.what());
    return 1;
  }
}
