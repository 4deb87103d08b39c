#include "apps/simulators/motes/program.h"

int main(int argc, char** argv) {
  return rubicon::motes_simulator::run_program(argc, argv);
}
