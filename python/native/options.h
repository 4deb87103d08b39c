#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <utility>

#include "rubicon/client.hpp"

namespace rubicon::python {

namespace py = pybind11;

/// Raises rubicon.Error.
[[noreturn]] void raise(const Error& error);

template <class T>
T value_or_raise(Result<T> result) {
  if (!result) raise(result.error());
  return std::move(*result);
}

/// Members of a dict; what is missing is empty or zero.
std::string text(const py::dict& options, const char* name, const char* otherwise = "");
double seconds(const py::dict& options, const char* name);
bool flag(const py::dict& options, const char* name);
WallTime wall_time(double seconds);

/// Of rubicon.join().
client::Options options_of(const py::dict& options);
/// {minimum, maximum, dead_band, passive}
Flow flow_of(const py::dict& flow);

}  // namespace rubicon::python
