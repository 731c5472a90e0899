#pragma once
#include <CLI/App.hpp>

namespace wheatstone::apps {

/// Adds every subcommand to the program.
void add_commands(CLI::App&);

}  // namespace wheatstone::apps
