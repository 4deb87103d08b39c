#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

// All fuzz targets are one program, so that each file is compiled and linked once. It runs the target whose name it was
// started by: build/fuzz/bin/<name>_fuzz are links to it.
namespace rubicon::fuzz {

/// One input; 0 = done (libFuzzer).
using Run = int (*)(const std::uint8_t* data, std::size_t size);

/// Registers a target while it lives.
struct Target {
  /// `prepare` runs once, before the first input.
  Target(std::string_view name, Run run, void (*prepare)() = nullptr);
  std::string_view name;
  Run run;
  void (*prepare)();
};

/// nullptr before libFuzzer has begun.
const Target* chosen();

}  // namespace rubicon::fuzz

/// In place of LLVMFuzzerTestOneInput, in a namespace of its own.
#define FUZZ_TARGET(name, ...)                                                        \
  static int run(const std::uint8_t* data, std::size_t size);                         \
  static const ::rubicon::fuzz::Target target(#name, run __VA_OPT__(, ) __VA_ARGS__); \
  static int run(const std::uint8_t* data, std::size_t size)
