#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include <sys/types.h>

#include "builder/serve/http_message.h"
#include "cairn/status.h"

namespace cairn {

struct StreamLimits {
  int viewers = 4;      ///< at once; more are answered with 503
  int cache_mib = 256;  ///< of tiles in the memory of each viewer's process
};

/// Starts the program cairn-stream for each viewer that asks for pictures, and gives it the viewer's
/// connection. A viewer's process ends with its connection, and all end with the service. Any number of
/// threads may ask.
class StreamService {
 public:
  /// failed where the program is not there.
  static Result<std::unique_ptr<StreamService>> create(const StreamLimits& limits);
  ~StreamService();

  /// Answers a request for a WebSocket (RFC 6455) over which a pack is drawn.
  HttpAnswer answer(const HttpRequest& request, const std::filesystem::path& pack);

 private:
  struct Viewer {
    pid_t process = 0;
    bool ended = false;
    std::thread waits;
  };
  StreamService(std::filesystem::path program, const StreamLimits& limits);
  void start(int socket, const std::string& key, const std::filesystem::path& pack);
  bool has_place();
  void forget_ended();

  std::filesystem::path program_;
  StreamLimits limits_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Viewer>> viewers_;
};

}  // namespace cairn
