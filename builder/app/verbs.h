#pragma once

namespace CLI {
class App;
}

namespace cairn {

/// Each adds one verb to the program. Parsing arguments that name it runs it and leaves the program's exit
/// status in `exit_code`: 0 ok, 1 failed, 2 usage, 3 bad input data.
void add_bake(CLI::App& app, int& exit_code);
void add_plan(CLI::App& app, int& exit_code);
void add_merge(CLI::App& app, int& exit_code);
void add_update(CLI::App& app, int& exit_code);
void add_info(CLI::App& app, int& exit_code);
void add_verify(CLI::App& app, int& exit_code);
void add_sample(CLI::App& app, int& exit_code);
void add_extract(CLI::App& app, int& exit_code);
void add_export(CLI::App& app, int& exit_code);
void add_hillshade(CLI::App& app, int& exit_code);
void add_serve(CLI::App& app, int& exit_code);
void add_diff(CLI::App& app, int& exit_code);
void add_inspect(CLI::App& app, int& exit_code);

}  // namespace cairn
