#pragma once

#include <cstdio>
#include <filesystem>
#include <string>

#include <sys/types.h>

namespace cairn::test {

/// A local HTTP server of the files of a folder, with every fault of a network: see range_server.py. Ends
/// with the object.
class RangeServer {
 public:
  explicit RangeServer(const std::filesystem::path& folder);
  ~RangeServer();
  RangeServer(const RangeServer&) = delete;
  RangeServer& operator=(const RangeServer&) = delete;

  std::string address(const std::string& fault, const std::string& file) const;

 private:
  pid_t child_ = -1;
  int input_ = -1;  // of the server, which ends when this is closed
  int port_ = 0;
};

}  // namespace cairn::test
