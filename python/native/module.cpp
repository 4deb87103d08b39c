#include "native/component.h"

namespace rubicon::python {

PYBIND11_MODULE(_native, module) {
  module.doc() = "The client library of Rubicon, for rubicon.join().";
  py::class_<Component>(module, "Component")
      .def(py::init<const py::dict&>())
      .def_property_readonly("id", &Component::id)
      .def("descriptor", &Component::descriptor)
      .def("poll", &Component::poll)
      .def("close", &Component::close)
      .def("islands", &Component::islands)
      .def("read", &Component::read)
      .def("subscribe", &Component::subscribe)
      .def("write", &Component::write)
      .def("own", &Component::own)
      .def("erase", &Component::erase)
      .def("judge", &Component::judge)
      .def("send", &Component::send)
      .def("listen", &Component::listen)
      .def("end", &Component::end);
}

}  // namespace rubicon::python
