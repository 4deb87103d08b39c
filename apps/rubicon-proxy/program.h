#pragma once

namespace rubicon::daemon {

/// The program rubicon-proxy: does what its command line says. Returns its exit code.
int run_program(int argc, char** argv);

}  // namespace rubicon::daemon
