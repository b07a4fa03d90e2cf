#include <kinora/testing/setting.h>
#include <kinora/testing/statistics.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "plugin/types.h"

namespace kinora::testing {

namespace {

std::string_view trim(std::string_view s) {
  const size_t a = s.find_first_not_of(" \t\n"), b = s.find_last_not_of(" \t\n");
  return a == s.npos ? std::string_view() : s.substr(a, b - a + 1);
}

std::string written(const std::vector<float>& v) {
  std::string r;
  char buffer[32];
  for (const float x : v) {
    std::snprintf(buffer, sizeof buffer, "%s%.9g", r.empty() ? "" : " ", double(x));
    r += buffer;
  }
  return r;
}

void assign(Setting& s, const Descriptor& d, uint32_t i, std::vector<float> numbers) {
  if (numbers == s.numbers[i]) return;
  if (!s.given[i]) s.text = (s.text == "defaults" ? "" : s.text + "; ") + d.params[i].name + "=" + written(numbers);
  s.numbers[i] = std::move(numbers);
  s.given[i] = true;
}
void assign(Setting& s, const Descriptor& d, uint32_t i, const std::string& word) {
  if (s.strings[i].size() == 1 && s.strings[i][0] == word) return;
  if (!s.given[i]) s.text = (s.text == "defaults" ? "" : s.text + "; ") + d.params[i].name + "=" + word;
  s.strings[i] = {word};
  s.given[i] = true;
}

// What a parameter may be set to by itself: the ends of its range, or each of its choices. Index 0 is the default.
struct Levels {
  std::vector<std::vector<float>> numbers;
  std::vector<std::string> words;
  size_t count() const { return std::max(numbers.size(), words.size()); }
};

std::vector<std::string> splitChoices(const std::string& list, char separator) {
  std::vector<std::string> r;
  size_t at = 0;
  while (at <= list.size()) {
    const size_t end = std::min(list.find(separator, at), list.size());
    const std::string_view word = trim(std::string_view(list).substr(at, end - at));
    if (!word.empty()) r.emplace_back(word);
    at = end + 1;
  }
  return r;
}

Levels levelsOf(const Param& p, const Setting& defaults, uint32_t i) {
  Levels l;
  if (p.flags & (kParamOutput | kParamArray | kParamFile)) return l;
  const auto add = [&](std::vector<float> v) {
    if (std::find(l.numbers.begin(), l.numbers.end(), v) == l.numbers.end()) l.numbers.push_back(std::move(v));
  };
  const std::vector<float>& def = defaults.numbers[i];
  switch (p.type) {
    case Type::Int: {
      add(def);
      const std::string choices = p.choices;
      if (choices.find(',') != choices.npos) {
        for (const std::string& c : splitChoices(choices, ',')) add({float(std::atoi(c.c_str()))});
      } else if (p.high - p.low <= 16) {
        for (int v = int(p.low); v <= int(p.high); ++v) add({float(v)});
      } else {
        add({p.low});
        add({p.high});
      }
      break;
    }
    case Type::Float:
      add(def);
      add({p.low});
      add({p.high});
      break;
    case Type::Color:
    case Type::Point:
    case Type::Vector:
      add(def);
      add({p.low, p.low, p.low});
      add({p.high, p.high, p.high});
      break;
    case Type::Normal:
      add(def);
      // 0 0 0 means "not connected"; else tilted against the test's normal, and nearly averted
      add({0.1f, -0.25f, 0.96f});
      add({p.low, p.high, p.low});
      break;
    case Type::String:
      for (const std::string& word : defaults.strings[i]) l.words.push_back(word);
      for (const std::string& c : splitChoices(p.choices, '|'))
        if (std::find(l.words.begin(), l.words.end(), c) == l.words.end()) l.words.push_back(c);
      if (l.words.size() < 2) l.words.clear();
      break;
    case Type::Matrix:
    case Type::Struct:
      break;
  }
  return l;
}

void assignLevel(Setting& s, const Descriptor& d, uint32_t i, const Levels& l, size_t level) {
  if (level < l.numbers.size())
    assign(s, d, i, l.numbers[level]);
  else if (level < l.words.size())
    assign(s, d, i, l.words[level]);
}

// Rows in which each pair of columns shows each pair of levels: greedy, one row at a time, columns in random order,
// each taking the level that covers most pairs not yet seen.
std::vector<std::vector<uint8_t>> coveringArray(const std::vector<uint8_t>& levels, Random& random) {
  const size_t columns = levels.size();
  constexpr size_t kMost = 16;
  std::vector<uint8_t> seen(columns * columns * kMost * kMost, 0);
  const auto pair = [&](size_t a, size_t la, size_t b, size_t lb) -> uint8_t& {
    return a < b ? seen[((a * columns + b) * kMost + la) * kMost + lb]
                 : seen[((b * columns + a) * kMost + lb) * kMost + la];
  };
  size_t open = 0;
  for (size_t a = 0; a < columns; ++a)
    for (size_t b = a + 1; b < columns; ++b) open += size_t(levels[a]) * levels[b];
  std::vector<std::vector<uint8_t>> rows;
  while (open && rows.size() < 400) {
    std::vector<size_t> order(columns);
    for (size_t i = 0; i < columns; ++i) order[i] = i;
    for (size_t i = columns; i > 1; --i) std::swap(order[i - 1], order[random.below(uint32_t(i))]);
    std::vector<uint8_t> row(columns, 0);
    size_t covered = 0;
    for (size_t k = 0; k < columns; ++k) {
      const size_t column = order[k];
      int best = -1;
      const uint32_t start = random.below(levels[column]);
      for (uint32_t j = 0; j < levels[column]; ++j) {
        const size_t level = (start + j) % levels[column];
        int fresh = 0;
        for (size_t m = 0; m < k; ++m) fresh += !pair(column, level, order[m], row[order[m]]);
        if (fresh > best) {
          best = fresh;
          row[column] = uint8_t(level);
        }
      }
      for (size_t m = 0; m < k; ++m) {
        uint8_t& s = pair(column, row[column], order[m], row[order[m]]);
        covered += !s;
        s = 1;
      }
    }
    open -= covered;
    if (covered || open) rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

Setting defaultSetting(const Descriptor& d) {
  Setting s;
  s.text = "defaults";
  s.numbers.resize(d.paramCount);
  s.strings.resize(d.paramCount);
  s.given.resize(d.paramCount, false);
  for (uint32_t i = 0; i < d.paramCount; ++i) {
    const Param& p = d.params[i];
    if (p.flags & kParamOutput) continue;
    if (p.flags & kParamArray) {
      if (p.list) s.numbers[i].assign(p.list, p.list + p.listCount);
    } else if (p.type == Type::String) {
      s.strings[i] = {p.text ? p.text : ""};
    } else if (p.type == Type::Matrix) {
      s.numbers[i] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    } else {
      s.numbers[i].assign(p.value, p.value + componentsOf(p.type));
    }
  }
  return s;
}

bool parseSetting(const Descriptor& d, std::string_view text, Setting& out, std::string& error) {
  out = defaultSetting(d);
  for (std::string_view rest = text; !rest.empty();) {
    const size_t end = std::min(rest.find(';'), rest.size());
    const std::string_view item = trim(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (item.empty()) continue;
    const size_t equals = item.find('=');
    if (equals == item.npos) {
      error = "'" + std::string(item) + "' is not name=value";
      return false;
    }
    const std::string_view name = trim(item.substr(0, equals)), value = trim(item.substr(equals + 1));
    uint32_t i = 0;
    while (i < d.paramCount && name != d.params[i].name) ++i;
    if (i == d.paramCount || (d.params[i].flags & kParamOutput)) {
      error = std::string(d.name) + " has no parameter '" + std::string(name) + "'";
      return false;
    }
    const Param& p = d.params[i];
    if (p.type == Type::Struct) {
      error = "'" + std::string(name) + "' is a struct and takes no value";
      return false;
    }
    out.given[i] = true;
    if (p.type == Type::String) {
      out.strings[i] = {std::string(value)};
      continue;
    }
    std::vector<float> numbers;
    const std::string copy(value);
    const char* at = copy.c_str();
    while (*at) {
      char* after = nullptr;
      const float x = std::strtof(at, &after);
      if (after == at || !std::isfinite(x) || (*after && *after != ' ')) {
        error = "'" + std::string(item) + "': not a list of finite numbers";
        return false;
      }
      numbers.push_back(x);
      at = after + std::string_view(after).find_first_not_of(' ');
      if (std::string_view(after).find_first_not_of(' ') == std::string_view::npos) break;
    }
    const uint32_t wanted = componentsOf(p.type);
    if (numbers.empty() || (!(p.flags & kParamArray) && numbers.size() != wanted) || numbers.size() % wanted) {
      error = "'" + std::string(item) + "': " + std::to_string(wanted) + " numbers wanted";
      return false;
    }
    out.numbers[i] = std::move(numbers);
  }
  const std::string_view shown = trim(text);
  if (!shown.empty()) out.text = shown;
  return true;
}

std::vector<Setting> coveringSettings(const Descriptor& d, uint32_t randomCount, uint64_t seed) {
  const Setting defaults = defaultSetting(d);
  std::vector<Setting> list{defaults};
  std::vector<uint32_t> walked;
  std::vector<Levels> levels;
  std::vector<uint8_t> counts;
  for (uint32_t i = 0; i < d.paramCount; ++i) {
    Levels l = levelsOf(d.params[i], defaults, i);
    if (l.count() < 2) continue;
    for (size_t level = 1; level < l.count(); ++level) {
      list.push_back(defaults);
      assignLevel(list.back(), d, i, l, level);
    }
    walked.push_back(i);
    counts.push_back(uint8_t(std::min<size_t>(l.count(), 16)));
    levels.push_back(std::move(l));
  }
  Random random(seed);
  for (const std::vector<uint8_t>& row : coveringArray(counts, random)) {
    list.push_back(defaults);
    for (size_t k = 0; k < walked.size(); ++k) assignLevel(list.back(), d, walked[k], levels[k], row[k]);
  }
  for (uint32_t n = 0; n < randomCount; ++n) {
    Setting s = defaults;
    for (size_t k = 0; k < walked.size(); ++k) {
      const Param& p = d.params[walked[k]];
      if (p.type == Type::Int || p.type == Type::String) {
        assignLevel(s, d, walked[k], levels[k], random.below(uint32_t(levels[k].count())));
      } else if (p.type != Type::Normal || random.below(8) == 0) {
        std::vector<float> v(componentsOf(p.type));
        for (float& x : v) x = p.low + (p.high - p.low) * random.uniformFloat();
        assign(s, d, walked[k], std::move(v));
      }
    }
    list.push_back(std::move(s));
  }
  return list;
}

ResolvedValues::ResolvedValues(const Descriptor& d, const Setting& s)
    : pointers_(d.paramCount), values_(d.paramCount) {
  for (uint32_t i = 0; i < d.paramCount; ++i) {
    ParamValue& v = values_[i];
    for (const std::string& text : s.strings[i]) pointers_[i].push_back(text.c_str());
    v.floats = s.numbers[i].empty() ? nullptr : s.numbers[i].data();
    v.strings = pointers_[i].empty() ? nullptr : pointers_[i].data();
    v.count = uint32_t(d.params[i].type == Type::String ? pointers_[i].size() : s.numbers[i].size());
    v.given = s.given[i];
  }
}

}  // namespace kinora::testing
