// What the commands' option parsers share. Called by each command; it prints help and version itself and turns a
// mistake into one message with exit code 2. It knows no option of any command.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/diagnostics.h"

namespace CLI {
class App;
}

namespace kinora::app {

// A parser with --help and --version that accepts options and files in any order.
std::shared_ptr<CLI::App> makeParser(const std::string& command, const std::string& help);

// Runs it. A value is the exit code with which the program is done: help was printed, or the command line is wrong.
std::optional<int> parse(CLI::App& parser, const std::vector<std::string>& arguments, Diagnostics& diagnostics);

// Reports a command line that parses but means nothing; returns the exit code.
int badCommandLine(Diagnostics& diagnostics, const std::string& what, const std::string& advice = {});

// Numbers separated by one character, nothing before or after: "640x360", "0:16", "10,20,3". False when not so.
bool splitInts(const std::string& text, char separator, std::vector<int>& out);

// The nearest of `names` to a misspelt one, as "did you mean NAME?"; "" when none is near.
std::string didYouMean(const std::string& name, const std::vector<std::string>& names);

}  // namespace kinora::app
