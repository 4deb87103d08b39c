#pragma once

namespace rubicon::salad_simulator {

/// The program salad-simulator: reads its command line and runs until it is told to end. Returns its exit code.
int run_program(int argc, char** argv);

}  // namespace rubicon::salad_simulator
