#pragma once

namespace rubicon::knx_simulator {

/// The program knx-simulator: reads its command line and runs until it is told to end. Returns its exit code.
int run_program(int argc, char** argv);

}  // namespace rubicon::knx_simulator
