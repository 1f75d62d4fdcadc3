#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>

#include "engine/error.h"
#include "tools/commands.h"

// hpdm: one program, one file a subcommand. Exit codes: 0 done, 1 a check failed, 2 bad input or
// usage (one line on stderr), 3 the machine lacks something that was asked for.
int main(int argc, char** argv) {
  CLI::App app("HPDM: a real-time engine for laparoscopic-surgery training", "hpdm");
  app.require_subcommand(1);
  app.set_version_flag("--version", HPDM_VERSION);
  hpdm::AddRunCommand(app, {argv, argv + argc});
  hpdm::AddReplayCommand(app);
  hpdm::AddReportCommand(app);
  hpdm::AddSpyCommand(app);
  hpdm::AddLogCommand(app);
  hpdm::AddCheckCommand(app);
  hpdm::AddInspectCommand(app);
  hpdm::AddSolveCommand(app);
  hpdm::AddChartCommand(app);
  hpdm::AddBenchCommand(app);
  hpdm::AddHapticsCommand(app);
  hpdm::AddStressCommand(app);
  hpdm::AddGenerateCommand(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    return app.exit(asked);
  } catch (const CLI::RuntimeError& check_failed) {
    return check_failed.get_exit_code();
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "hpdm: %s; see hpdm --help\n", error.what());
    return 2;
  } catch (const hpdm::InputError& error) {
    std::fprintf(stderr, "hpdm: %s\n", error.what());
    return 2;
  } catch (const hpdm::MachineError& error) {
    std::fprintf(stderr, "hpdm: %s\n", error.what());
    return 3;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "hpdm: out of memory; take fewer lattice cells or a coarser mesh\n");
    return 3;
  } catch (const std::exception& error) {  // caught so that destructors run: a terminal is restored
    std::fprintf(stderr, "hpdm: %s; see hpdm --help\n", error.what());
    return 3;
  }
  return 0;
}
