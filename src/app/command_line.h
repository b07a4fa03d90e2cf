// What the commands' option parsers share. Called by each command; it prints help and version itself and turns a
// mistake into one message with exit code 2. It knows no option of any command.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/diagnostics.h"
#include "base/near_name.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace kinora::app {

// A parser with --help and --version that accepts options and files in any order.
std::shared_ptr<CLI::App> makeParser(const std::string& command, const std::string& help);

// Of an option that may be repeated: each use takes one value, so that a file may follow.
void takeOneAtATime(CLI::Option* option);

// Runs it. A value is the exit code with which the program is done: help was printed, or the command line is wrong.
std::optional<int> parse(CLI::App& parser, const std::vector<std::string>& arguments, Diagnostics& diagnostics);

// Reports a command line that parses but means nothing; returns the exit code.
int badCommandLine(Diagnostics& diagnostics, const std::string& what, const std::string& advice = {});

// Whether writing `output` would take the place of one of `inputs`; says so then (exit code 2).
bool isOverInput(Diagnostics& diagnostics, const std::string& output, const std::vector<std::string>& inputs);

// Numbers separated by one character, nothing before or after: "640x360", "0:16", "10,20,3". False when not so.
bool splitInts(const std::string& text, char separator, std::vector<int>& out);

// The option --crop, for readCrop().
void addCrop(CLI::App& parser, std::vector<float>& numbers, const std::string& help);

// Four numbers of --crop as XMIN XMAX YMIN YMAX; what is wrong with them, or nothing.
std::optional<std::string> readCrop(const std::vector<float>& numbers, std::array<float, 4>& out);

// FROM=TO; false when it is not.
bool parseDirmap(const std::string& text, std::vector<std::pair<std::string, std::string>>& out);

}  // namespace kinora::app
