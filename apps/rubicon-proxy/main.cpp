#include "apps/rubicon-proxy/program.h"

int main(int argc, char** argv) {
  return rubicon::daemon::run_program(argc, argv);
}
