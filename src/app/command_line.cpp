#include "app/command_line.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <numeric>

#include "app/exit_codes.h"
#include "render/version.h"

namespace kinora::app {

std::shared_ptr<CLI::App> makeParser(const std::string& command, const std::string& help) {
  auto parser = std::make_shared<CLI::App>(help, "kinora " + command);
  parser->set_version_flag("--version", std::string("kinora ") + kVersion, "print the version");
  parser->get_formatter()->column_width(34);
  return parser;
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
  return std::nullopt;
}

int badCommandLine(Diagnostics& diagnostics, const std::string& what, const std::string& advice) {
  diagnostics.error("APP-OPTION", {}, what, "nothing was done", advice);
  return kBadCommandLine;
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

namespace {

// Edits without case from one word to the other.
size_t distance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t(0));
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const bool same =
          std::tolower(static_cast<unsigned char>(a[i - 1])) == std::tolower(static_cast<unsigned char>(b[j - 1]));
      const size_t edited = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (same ? 0 : 1)});
      diagonal = row[j];
      row[j] = edited;
    }
  }
  return row.back();
}

}  // namespace

std::string didYouMean(const std::string& name, const std::vector<std::string>& names) {
  const std::string* best = nullptr;
  size_t least = std::max<size_t>(1, name.size() / 3) + 1;
  for (const std::string& n : names)
    if (const size_t d = distance(name, n); d < least) {
      least = d;
      best = &n;
    }
  return best ? "did you mean " + *best + "?" : std::string();
}

}  // namespace kinora::app
