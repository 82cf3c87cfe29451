#include "tests/support/range_server.h"

#include <cstdlib>

#include <catch2/catch.hpp>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/test_data.h"

namespace cairn::test {

RangeServer::RangeServer(const std::filesystem::path& folder) {
  const std::string script = (sample_dem().parent_path() / "tests" / "support" / "range_server.py").string();
  int in[2], out[2];
  REQUIRE((::pipe(in) == 0 && ::pipe(out) == 0));
  child_ = ::fork();
  REQUIRE(child_ >= 0);
  if (child_ == 0) {
    ::dup2(in[0], 0);
    ::dup2(out[1], 1);
    for (const int end : {in[0], in[1], out[0], out[1]}) ::close(end);
    ::execl("/usr/bin/python3", "python3", script.c_str(), folder.c_str(), static_cast<char*>(nullptr));
    ::_exit(127);
  }
  ::close(in[0]);
  ::close(out[1]);
  input_ = in[1];
  std::string line;
  for (char c = 0; ::read(out[0], &c, 1) == 1 && c != '\n';) line += c;
  ::close(out[0]);
  port_ = std::atoi(line.c_str());
  REQUIRE(port_ > 0);
}

RangeServer::~RangeServer() {
  ::close(input_);
  ::waitpid(child_, nullptr, 0);
}

std::string RangeServer::address(const std::string& fault, const std::string& file) const {
  return "http://127.0.0.1:" + std::to_string(port_) + "/" + fault + "/" + file;
}

}  // namespace cairn::test
