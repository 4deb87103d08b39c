#include "apps/simulators/zigbee/simulator.h"

int main(int argc, char** argv) {
  return rubicon::zigbee_simulator::run_program(argc, argv);
}
