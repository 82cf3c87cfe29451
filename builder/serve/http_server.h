#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "builder/serve/http_message.h"
#include "cairn/status.h"

namespace cairn {

struct HttpLimits {
  int connections = 1024;             ///< more wait until one closes; fewer where the system allows fewer
  std::uint32_t header_bytes = 8192;  ///< of a request
  std::chrono::seconds request_time{
      15};  ///< in which a request's header is there whole, from the last answer on
  std::chrono::seconds piece_time{20};  ///< in which a client takes 64 KiB
};

/// A server of HTTP/1.1 for GET and HEAD. All its deadlines are of whole steps, so that a client that sends
/// or takes a byte now and then is cut off as well. Requests with a body, of another method, or larger than
/// the limits are refused.
class HttpServer {
 public:
  /// Listens; port 0 takes a free one. `address` is a number, IPv4 or IPv6. `failed` where that is not
  /// possible.
  static Result<HttpServer> listen(const std::string& address, std::uint16_t port, HttpHandler handler,
                                   const HttpLimits& limits = {});

  HttpServer(HttpServer&&) noexcept;
  ~HttpServer();

  std::uint16_t port() const;

  /// Serves until stop(); the handler runs on `threads` threads.
  void run(int threads);

  /// Ends run(). May be called by any thread.
  void stop();

 private:
  struct State;
  explicit HttpServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn
