#pragma once

namespace rubicon::zigbee_simulator {

/// The program zigbee-simulator: reads its command line and runs until a signal ends it. Returns its exit code.
int run_program(int argc, char** argv);

}  // namespace rubicon::zigbee_simulator
