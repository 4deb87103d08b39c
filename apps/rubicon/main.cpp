#include "apps/rubicon/cli.h"

int main(int argc, char** argv) {
  rubicon::cli::Cli cli;
  return cli.run(argc, argv);
}
