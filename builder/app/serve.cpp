#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include "builder/app/report_error.h"
#include "builder/app/verbs.h"
#include "builder/serve/http_server.h"
#include "builder/serve/pack_service.h"
#include "builder/serve/stream_service.h"

namespace cairn {
namespace {

struct ServeOptions {
  std::vector<std::string> packs;
  std::string address = "127.0.0.1";
  std::uint16_t port = 8080;
  bool streams = false;
  StreamLimits stream_limits;
};

/// Returns the folder of the page: that of the installed tree, or of the build's, where this program lies.
std::optional<std::filesystem::path> find_page() {
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return std::nullopt;
  for (const char* place : {"../share/cairn/web", "../web"}) {
    const auto folder = (self.parent_path() / place).lexically_normal();
    if (std::filesystem::is_regular_file(folder / "index.html", error)) return folder;
  }
  return std::nullopt;
}

int run_serve(const ServeOptions& options) {
  const auto page = find_page();
  std::unique_ptr<StreamService> streams;
  if (options.streams) {
    auto found = StreamService::create(options.stream_limits);
    if (!found) return report_error(found.error());
    streams = std::move(*found);
  }
  const auto service =
      PackService::open({options.packs.begin(), options.packs.end()}, page, std::move(streams));
  if (!service) return report_error(service.error());

  // Blocked before any thread begins, so that only sigwait() below takes them.
  sigset_t signals;
  sigemptyset(&signals);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, number);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);

  auto server = HttpServer::listen(options.address, options.port,
                                   [&](const HttpRequest& request) { return service->answer(request); });
  if (!server) return report_error(server.error());
  const bool is_v6 = options.address.find(':') != std::string::npos;
  fmt::print("http://{}{}{}:{}/\n", is_v6 ? "[" : "", options.address, is_v6 ? "]" : "", server->port());
  if (!page) fmt::print(stderr, "cairn: serve: the page for browsers is not installed\n");
  std::fflush(stdout);
  std::thread waits([&] {
    int number = 0;
    sigwait(&signals, &number);
    server->stop();
  });
  server->run(static_cast<int>(std::max(2u, std::thread::hardware_concurrency())));
  waits.join();
  return 0;
}

}  // namespace

void add_serve(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<ServeOptions>();
  CLI::App* verb = app.add_subcommand(
      "serve", "Serve packs over HTTP: a page that flies over them, their bytes, heights and tiles");
  verb->add_option("PACK", options->packs, "The packs, which are served under their files' names")
      ->required();
  verb->add_option("--bind", options->address,
                   "The address to listen on; 0.0.0.0 lets other machines reach the packs")
      ->capture_default_str();
  verb->add_option("--port", options->port, "0 takes a free one; the address is printed")
      ->capture_default_str();
  CLI::Option* stream = verb->add_flag(
      "--stream", options->streams,
      "Draw pictures for clients without a GPU, in a process for each; needs cairn-stream and OpenGL 4.5");
  verb->add_option("--viewers", options->stream_limits.viewers, "With --stream: clients drawn for at once")
      ->needs(stream)
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  verb->add_option("--cache", options->stream_limits.cache_mib, "With --stream: MiB of tiles for each client")
      ->needs(stream)
      ->check(CLI::Range(16, 1 << 20))
      ->capture_default_str();
  verb->callback([options, &exit_code] { exit_code = run_serve(*options); });
}

}  // namespace cairn
