#include "app/command_line.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <charconv>

#include "app/exit_codes.h"
#include "image/atomic_file.h"
#include "render/version.h"

namespace kinora::app {

std::shared_ptr<CLI::App> makeParser(const std::string& command, const std::string& help) {
  auto parser = std::make_shared<CLI::App>(help, "kinora " + command);
  parser->set_version_flag("--version", std::string("kinora ") + kVersion, "print the version");
  parser->get_formatter()->column_width(34);
  return parser;
}

void takeOneAtATime(CLI::Option* option) {
  option->expected(1)->allow_extra_args(false)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

std::optional<int> parse(CLI::App& parser, const std::vector<std::string>& arguments, Diagnostics& diagnostics) {
  try {
    parser.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) {
      parser.exit(e);
      return kComplete;
    }
    std::string what = e.what();
    if (!what.empty() && what.back() == '.') what.pop_back();
    return badCommandLine(diagnostics, what, "see `" + parser.get_name() + " --help`");
  }
  // "" is a variable of a script that was not set
  for (const CLI::Option* option : parser.get_options())
    for (const std::string& value : option->results())
      if (value.empty())
        return badCommandLine(diagnostics, option->get_name() + " is given an empty value",
                              "see `" + parser.get_name() + " --help`");
  return std::nullopt;
}

int badCommandLine(Diagnostics& diagnostics, const std::string& what, const std::string& advice) {
  diagnostics.error("APP-OPTION", {}, what, "nothing was done", advice);
  return kBadCommandLine;
}

bool isOverInput(Diagnostics& diagnostics, const std::string& output, const std::vector<std::string>& inputs) {
  for (const std::string& input : inputs)
    if (image::isSameFile(output, input)) {
      badCommandLine(diagnostics, "'" + output + "' would be written over the input '" + input + "'",
                     "name another file to write");
      return true;
    }
  return false;
}

void addCrop(CLI::App& parser, std::vector<float>& numbers, const std::string& help) {
  parser.add_option("--crop", numbers, help)->type_name("XMIN XMAX YMIN YMAX")->expected(4)->allow_extra_args(false);
}

std::optional<std::string> readCrop(const std::vector<float>& c, std::array<float, 4>& out) {
  // written so that NaN fails
  if (c.size() != 4 || !(c[0] >= 0 && c[0] < c[1] && c[1] <= 1 && c[2] >= 0 && c[2] < c[3] && c[3] <= 1))
    return "--crop takes XMIN XMAX YMIN YMAX within 0..1, each MIN below its MAX";
  out = {c[0], c[1], c[2], c[3]};
  return {};
}

bool splitInts(const std::string& text, char separator, std::vector<int>& out) {
  out.clear();
  const char *at = text.data(), *end = at + text.size();
  for (;;) {
    int value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || next == at) return false;
    out.push_back(value);
    if (next == end) return true;
    if (*next != separator) return false;
    at = next + 1;
  }
}

bool parseDirmap(const std::string& text, std::vector<std::pair<std::string, std::string>>& out) {
  const size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos) return false;
  out.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  return true;
}

}  // namespace kinora::app
