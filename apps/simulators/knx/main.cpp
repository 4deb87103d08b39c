#include "apps/simulators/knx/simulator.h"

int main(int argc, char** argv) {
  return rubicon::knx_simulator::run_program(argc, argv);
}
