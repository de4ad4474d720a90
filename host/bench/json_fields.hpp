// SPDX-License-Identifier: MIT
// One list of fields per record, for writing and for reading, so that the two cannot drift apart.
#pragma once

#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "host/base/error.hpp"
#include "host/bench/results.hpp"

namespace glint::bench {

using Json = nlohmann::ordered_json;

/// For fields(): a record, const when it is written.
template <typename T, typename Record>
concept Is = std::is_same_v<std::remove_const_t<T>, Record>;

inline constexpr std::array<const char*, 3> kOutcomeWords{"ok", "FAIL", "error"};  ///< index: Outcome

/// fields(archive, record) calls archive("name", record.member) for each member; it is overloaded per record.
class JsonWriter {
 public:
  explicit JsonWriter(bool samples) : samples_(samples) {}

  template <typename T>
  Json operator()(const T& value) const {
    if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) {
      return value;
    } else if constexpr (std::is_same_v<T, Outcome>) {
      return kOutcomeWords[static_cast<std::size_t>(value)];
    } else {
      Json object = Json::object();
      Members members{*this, object};
      fields(members, value);
      return object;
    }
  }
  template <typename T>
  Json operator()(const std::vector<T>& values) const {
    Json array = Json::array();
    for (const T& value : values) array.push_back((*this)(value));
    return array;
  }
  template <typename T>
  Json operator()(const std::optional<T>& value) const {
    return value ? (*this)(*value) : Json();
  }

 private:
  struct Members {
    const JsonWriter& writer;
    Json& object;
    template <typename T>
    void operator()(const char* name, const T& value) {
      object[name] = writer(value);
    }
    /// A list that need not be there.
    void samples(const char* name, const std::vector<double>& values) {
      if (writer.samples_) object[name] = writer(values);
    }
  };
  bool samples_;
};

/// Throws Error with the place in the file for whatever is missing or of another kind.
class JsonReader {
 public:
  JsonReader(const Json& json, std::string place) : json_(json), place_(std::move(place)) {}

  template <typename T>
  void read(T& value) const {
    if constexpr (std::is_same_v<T, bool>) {
      if (!json_.is_boolean()) refuse("must be true or false");
      value = json_.get<bool>();
    } else if constexpr (std::is_floating_point_v<T>) {
      if (!json_.is_number()) refuse("must be a number");
      value = json_.get<T>();
      if (!std::isfinite(value)) refuse("must be a finite number");
    } else if constexpr (std::is_integral_v<T>) {
      if (!json_.is_number_unsigned() || json_.get<std::uint64_t>() > std::numeric_limits<T>::max())
        refuse("must be a whole number from 0 to " + std::to_string(std::numeric_limits<T>::max()));
      value = json_.get<T>();
    } else if constexpr (std::is_same_v<T, std::string>) {
      if (!json_.is_string()) refuse("must be a text");
      value = json_.get<std::string>();
    } else if constexpr (std::is_same_v<T, Outcome>) {
      std::size_t index = 0;
      while (index < kOutcomeWords.size() && json_ != kOutcomeWords[index]) ++index;
      if (index == kOutcomeWords.size()) refuse("must be \"ok\", \"FAIL\" or \"error\"");
      value = static_cast<Outcome>(index);
    } else {
      if (!json_.is_object()) refuse("must be an object");
      Members members{*this};
      fields(members, value);
    }
  }
  template <typename T>
  void read(std::vector<T>& values) const {
    if (!json_.is_array()) refuse("must be a list");
    values.clear();
    for (std::size_t i = 0; i < json_.size(); ++i)
      JsonReader(json_[i], place_ + "[" + std::to_string(i) + "]").read(values.emplace_back());
  }
  template <typename T>
  void read(std::optional<T>& value) const {
    value.reset();
    if (!json_.is_null()) read(value.emplace());
  }

  [[noreturn]] void refuse(const std::string& why) const { throw Error(place_ + ": " + why); }

 private:
  struct Members {
    const JsonReader& reader;
    template <typename T>
    void operator()(const char* name, T& value) {
      const auto found = reader.json_.find(name);
      if (found == reader.json_.end()) reader.refuse("no key \"" + std::string(name) + "\"");
      // "FILE: " ends with a blank: the first name needs no dot
      JsonReader(*found, reader.place_ + (reader.place_.ends_with(' ') ? "" : ".") + name).read(value);
    }
    void samples(const char* name, std::vector<double>& values) {
      values.clear();
      if (reader.json_.contains(name)) (*this)(name, values);
    }
  };
  const Json& json_;
  std::string place_;
};

}  // namespace glint::bench
