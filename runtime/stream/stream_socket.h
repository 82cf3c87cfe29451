#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cairn/status.h"

namespace cairn::stream {

/// A WebSocket (RFC 6455) to one viewer, over a connection whose request another process has read. A thread
/// of its own sends and receives; its functions are for one other thread. A viewer that does not answer for
/// half a minute, sends more than 4 KiB in a message, or 1,024 messages that nobody takes, is cut off.
class StreamSocket {
 public:
  /// Answers the request, whose field Sec-WebSocket-Key is `key`. Takes over the descriptor, a TCP socket.
  static Result<std::unique_ptr<StreamSocket>> accept(int descriptor, const std::string& key);
  ~StreamSocket();

  /// Returns the messages that came since the last call, oldest first; waits for one for `patience` at most.
  /// nullopt once the connection has ended.
  std::optional<std::vector<std::string>> receive(std::chrono::milliseconds patience);

  /// Sends a binary message when those before it have been sent.
  void send(std::string message);

  /// Ends the connection with a reason, of which a viewer gets 123 bytes at most.
  void close(const std::string& reason);

 private:
  struct State;
  explicit StreamSocket(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn::stream
