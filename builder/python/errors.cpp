#include "builder/python/errors.h"

namespace cairn {
namespace py = pybind11;
namespace {

[[noreturn]] void raise_as(const char* name, const std::string& message) {
  const py::object type = py::module_::import("cairn._cairn").attr(name);
  PyErr_SetString(type.ptr(), message.c_str());
  throw py::error_already_set();
}

void add(py::module_& module, const char* name, const py::object& bases, const char* about) {
  const std::string full = std::string("cairn.") + name;
  module.attr(name) =
      py::reinterpret_steal<py::object>(PyErr_NewExceptionWithDoc(full.c_str(), about, bases.ptr(), nullptr));
}

}  // namespace

void add_errors(py::module_& module) {
  const auto builtin = [](PyObject* type) { return py::reinterpret_borrow<py::object>(type); };
  add(module, "Error", builtin(PyExc_RuntimeError),
      "What cairn could not do: the machine, or the error bound of a bake.");
  const py::object base = module.attr("Error");
  const py::object value_error = builtin(PyExc_ValueError);
  add(module, "UsageError", py::make_tuple(base, value_error), "The caller's arguments are wrong.");
  add(module, "BadDataError", py::make_tuple(base, value_error),
      "A file is damaged, or not what it claims to be.");
  add(module, "Cancelled", base, "A bake whose progress callback returned False.");
}

void raise(const Error& error) {
  switch (error.code) {
    case ErrorCode::usage:
      raise_as("UsageError", error.message);
    case ErrorCode::bad_data:
      raise_as("BadDataError", error.message);
    case ErrorCode::failed:
      break;
  }
  raise_as("Error", error.message);
}

void raise_cancelled(const std::string& message) {
  raise_as("Cancelled", message);
}

}  // namespace cairn
