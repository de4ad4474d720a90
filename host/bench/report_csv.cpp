// SPDX-License-Identifier: MIT
// One line per quantity.
#include "host/bench/report_csv.hpp"

#include <cstdio>

namespace glint::bench {
namespace {

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + '"';
}

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

const char* word(Outcome outcome) {
  return outcome == Outcome::Ok ? "ok" : outcome == Outcome::Wrong ? "FAIL" : "error";
}

/// What a line begins with: device and scene.
std::string key(const DeviceResult& device, const SceneKey& scene) {
  const std::string type = device.vulkan ? device.vulkan->device_type : "cpu";
  return quoted(device.name) + "," + type + "," + (device.software ? "1" : "0") + "," +
         std::to_string(scene.cameras) + "," + std::to_string(scene.width_px) + "," +
         std::to_string(scene.height_px) + "," + std::to_string(scene.blobs) + "," + number(scene.noise_grey);
}

class Lines {
 public:
  explicit Lines(bool compared) : compared_(compared) {
    text_ =
        "device,type,software,cameras,width_px,height_px,blobs,noise_grey,outcome,quantity,unit,value,count,"
        "p50,p90,p99,max";
    text_ += compared ? ",old_p50,ratio,verdict,problem\n" : ",problem\n";
  }

  void problem(const std::string& key, Outcome outcome, const std::string& quantity,
               const std::string& problem) {
    add(key, outcome, quantity, ",,,,,,", {}, problem);
  }
  void value(const std::string& key, const std::string& quantity, const std::string& unit, double value) {
    add(key, Outcome::Ok, quantity, unit + "," + number(value) + ",,,,,", {}, "");
  }
  void series(const std::string& key, const std::string& quantity, const Summary& s,
              const std::optional<Change>& change) {
    add(key, Outcome::Ok, quantity,
        "s,," + std::to_string(s.count) + "," + number(s.p50) + "," + number(s.p90) + "," + number(s.p99) +
            "," + number(s.max),
        change, "");
  }
  std::string text() const { return text_; }

 private:
  void add(const std::string& key, Outcome outcome, const std::string& quantity, const std::string& figures,
           const std::optional<Change>& change, const std::string& problem) {
    text_ += key + "," + word(outcome) + "," + quoted(quantity) + "," + figures + ",";
    if (compared_) {
      text_ += change ? number(change->old_p50) + "," + number(change->ratio) + "," +
                            bench::text(change->verdict) + ","
                      : ",,,";
    }
    text_ += quoted(problem) + "\n";
  }

  bool compared_;
  std::string text_;
};

}  // namespace

std::string to_csv(const Results& results, const Baseline* baseline) {
  Lines lines(baseline != nullptr);
  for (const DeviceResult& device : results.devices) {
    for (const Row& row : device.rows) {
      const std::string start = key(device, row.scene);
      if (row.outcome != Outcome::Ok) {
        lines.problem(start, row.outcome, "check", row.problem);
        continue;
      }
      const Row* before =
          baseline == nullptr ? nullptr : matching_row(baseline->results, device.name, row.scene);
      for_each_series(row, [&](const std::string& name, const Series& series) {
        lines.series(start, name, series.summary, change_of(name, series, before));
      });
      lines.value(start, "throughput", "ticks/s", row.ticks_per_s);
      lines.value(start, "missed", "ticks", static_cast<double>(row.paced.missed));
      lines.value(start, "blobs", "per tick", row.blobs_per_tick);
    }
    for (const Headline& headline : device.headlines) {
      SceneKey scene = results.headline_scene;
      const std::string quantity = "most cameras at " + number(headline.rate_hz) + " Hz";
      if (headline.outcome != Outcome::Ok) {
        lines.problem(key(device, scene), headline.outcome, quantity, headline.problem);
      } else {
        lines.value(key(device, scene), quantity, "cameras", headline.cameras);
      }
    }
  }
  return lines.text();
}

}  // namespace glint::bench
