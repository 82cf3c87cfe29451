#pragma once

namespace cairn {

/// While it lives, the first SIGINT (Ctrl-C), SIGTERM or SIGHUP asks the work to end instead of ending the
/// program; a second one ends it at once. One at a time.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();  ///< the signals have their usual effect again
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  /// Returns whether a signal came.
  bool is_asked() const;

  /// Ends the program by the signal that came, so that whoever started it sees that; returns where none did.
  void end_program() const;
};

}  // namespace cairn
