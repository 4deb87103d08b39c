#include "apps/rubicon/program.h"

int main(int argc, char** argv) {
  return rubicon::cli::run_program(argc, argv);
}
