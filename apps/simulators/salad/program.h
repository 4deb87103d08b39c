#pragma once

namespace rubicon::salad_simulator {

/// The program salad-simulator: reads its command line and runs until a signal ends it. Returns its exit code.
int run_program(int argc, char** argv);

}  // namespace rubicon::salad_simulator
