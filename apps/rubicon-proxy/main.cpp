#include "apps/rubicon-proxy/daemon.h"

int main(int argc, char** argv) {
  return rubicon::daemon::run_program(argc, argv);
}
