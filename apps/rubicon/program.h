#pragma once

namespace rubicon::cli {

/// The program rubicon: does what its command line says. Returns its exit code.
int run_program(int argc, char** argv);

}  // namespace rubicon::cli
