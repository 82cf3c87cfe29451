#pragma once

#include <cassert>
#include <optional>
#include <string>
#include <utility>

namespace cairn {

/// The kind of a failure; also the programs' exit code.
enum class ErrorCode {
  failed = 1,    ///< the machine or the error bound: I/O, disk full, accuracy not kept
  usage = 2,     ///< the caller's arguments: an option out of range, an output that exists
  bad_data = 3,  ///< the input's bytes: truncated, damaged, or not what they claim to be
};

/// A failure, with one line to read: "FILE: PLACE: expected X, found Y".
struct Error {
  ErrorCode code = ErrorCode::failed;
  std::string message;
};

/// A value, or the error that prevented it. Reading the absent one is a programming error.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::move(value)) {}
  Result(Error error) : error_(std::move(error)) {}

  bool ok() const { return value_.has_value(); }
  explicit operator bool() const { return ok(); }

  T& value() & { return assert(ok()), *value_; }
  const T& value() const& { return assert(ok()), *value_; }
  T&& value() && { return assert(ok()), std::move(*value_); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  const Error& error() const { return assert(!ok()), error_; }

 private:
  std::optional<T> value_;
  Error error_;
};

/// Success, or an error.
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}

  bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  const Error& error() const { return assert(!ok()), *error_; }

 private:
  std::optional<Error> error_;
};

using Status = Result<void>;

inline Error bad_data(std::string message) {
  return {ErrorCode::bad_data, std::move(message)};
}
inline Error failed(std::string message) {
  return {ErrorCode::failed, std::move(message)};
}
inline Error usage_error(std::string message) {
  return {ErrorCode::usage, std::move(message)};
}

}  // namespace cairn
