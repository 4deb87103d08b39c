#pragma once

namespace rubicon::motes_simulator {

/// The program motes-simulator: reads its command line and runs until a signal ends it. Returns its exit code.
int run_program(int argc, char** argv);

}  // namespace rubicon::motes_simulator
