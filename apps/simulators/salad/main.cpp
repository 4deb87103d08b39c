#include "apps/simulators/salad/simulator.h"

int main(int argc, char** argv) {
  return rubicon::salad_simulator::run_program(argc, argv);
}
