#include <fstream>
#include <regex>
#include <sstream>

#include "motes/framing.h"
#include "scenarios/motes.h"

namespace rubicon::scenarios {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

const std::string kData = RUBICON_SOURCE_DIR "/../shared/data/motes/";

/// One recording of the original firmware, and how it is played.
struct Recording {
  std::string name;
  bool forwarder;  ///< as a forwarder's client heard it, greeting included; else the bytes of the serial line
  std::uint32_t island;
};

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// What a mote measured, by the annotations made with the recording.
using Counts = std::vector<std::pair<int, int>>;
std::map<std::string, Counts> annotated(const std::string& path) {
  static const std::regex line(R"(NET dest=\w+/\w+ src=\w+/(\w+)|light=(\d+) temp=(\d+))");
  const auto text = text_of(path);
  std::map<std::string, Counts> counts;
  std::string mote;
  for (std::sregex_iterator at(text.begin(), text.end(), line), end; at != end; ++at) {
    if ((*at)[1].matched) {
      mote = std::to_string(std::stoi((*at)[1].str(), nullptr, 16));
    } else {
      counts[mote].emplace_back(std::stoi((*at)[2].str()), std::stoi((*at)[3].str()));
    }
  }
  return counts;
}

/// Whoever connects hears a recording from its beginning, a message each `pace` after the first one, and serial
/// acknowledgements between them. Nothing in it answers commands.
class Player {
 public:
  Player(Scheduler& scheduler, transport::MemoryNet& net, const Recording& recording, const std::string& bytes,
         Duration pace)
      : scheduler_(scheduler), serial_(!recording.forwarder), pace_(pace) {
    serial_ ? cut_frames(bytes) : cut_packets(bytes);
    listener_ = net.tcp.listen({"10.0.0.9", 9102}, [this](auto stream) {
      stream_ = std::move(stream);
      next_ = 0;
      say_next();
      return calls();
    });
  }
  bool ended() const { return next_ == pieces_.size(); }

 private:
  void cut_packets(const std::string& bytes) {
    pieces_.push_back(bytes.substr(0, 2));
    for (std::size_t at = 2; at < bytes.size();) {
      const auto size = 1U + static_cast<std::uint8_t>(bytes[at]);
      pieces_.push_back(bytes.substr(at, size));
      at += size;
    }
  }
  void cut_frames(const std::string& bytes) {
    for (std::size_t at = 0; at < bytes.size();) {
      const auto end = std::min(bytes.find('\x7e', at + 1), bytes.size() - 1) + 1;
      pieces_.push_back(bytes.substr(at, end - at));
      at = end;
    }
  }
  transport::TcpCallbacks calls() {
    transport::TcpCallbacks calls;
    calls.received = [this](ByteView bytes) {
      while (serial_) {
        const auto frame = reader_.next(bytes);
        if (!frame) return;
        if (frame->protocol == motes::kHdlcAckedPacket) std::ignore = stream_->send(motes::hdlc_ack(frame->sequence));
      }
    };
    calls.failed = [this](const Error&) { later_.cancel(); };
    return calls;
  }
  void say_next() {
    if (ended()) return;
    // The first piece is a forwarder's greeting, which is due within ForwarderSink::kGreetingTime.
    later_ = scheduler_.after(next_ == 0 ? Duration(100ms) : pace_, [this] {
      std::ignore = stream_->send(base::as_bytes(pieces_[next_++]));
      say_next();
    });
  }

  Scheduler& scheduler_;
  bool serial_;
  Duration pace_;
  std::vector<std::string> pieces_;
  std::size_t next_ = 0;
  motes::HdlcReader reader_;
  std::unique_ptr<transport::TcpStream> stream_;
  std::unique_ptr<transport::MemoryListener> listener_;
  Timer later_;
};

class RecordedMotes : public Motes, public testing::WithParamInterface<Recording> {
 protected:
  void SetUp() override {
    expected_ = annotated(kData + GetParam().name + ".annot.txt");
    bytes_ = text_of(kData + GetParam().name + ".bin");
    if (bytes_.empty() || expected_.empty()) GTEST_SKIP() << "no recordings in " << kData;
    ASSERT_THAT(expected_, SizeIs(2)) << "motes 2 and 3";
  }
  /// Plays all of it; the values of both motes' sensors of these types.
  void play(const std::string& units, const std::vector<std::string>& sensors) {
    const Player player(scheduler, net, GetParam(), bytes_, pace_);
    const auto source = GetParam().forwarder ? "sf@10.0.0.9:9102" : "network@10.0.0.9:9102";
    start(GetParam().island,
          std::string("wsn-1: {type: wsn, share: no, units: ") + units + ", source: \"" + source + "\"}");
    for (const auto& [mote, counts] : expected_) {
      for (const auto& sensor : sensors)
        heard_[mote + "." + sensor] = hear(GetParam().island, "wsn-1." + mote + ".sensor." + sensor);
    }
    for (int i = 0; i < 10000 && !player.ended(); ++i) {
      scheduler.run_for(100ms);
      if (demands_.empty() && !wanted_.empty() && reachable(GetParam().island, "wsn-1.3")) {
        for (const auto& [mote, counts] : expected_)
          demands_.push_back(want(GetParam().island, "wsn-1." + mote + ".sensor." + wanted_));
      }
    }
    scheduler.run_for(1s);
    EXPECT_TRUE(player.ended());
    for (const auto& [mote, counts] : expected_) EXPECT_TRUE(reachable(GetParam().island, "wsn-1." + mote)) << mote;
    EXPECT_EQ(seen(GetParam().island, "proxy.wsn-1.devices"), R"(["2","3"])");
  }
  const std::vector<std::string>& values(const std::string& point) { return heard_.at(point)->values; }
  /// A message each `pace`; once both motes are there, these sensors are subscribed to.
  void while_wanting(const std::string& sensor, Duration pace) {
    wanted_ = sensor;
    pace_ = pace;
  }

  std::map<std::string, Counts> expected_;
  std::string bytes_;
  std::map<std::string, std::unique_ptr<Heard>> heard_;

 private:
  Duration pace_ = 100ms;
  std::string wanted_;
  std::vector<Handle> demands_;
};

TEST_P(RecordedMotes, BecomeTuplesInPhysicalUnits) {
  play("physical", {"light-1", "temperature-1"});
  for (const auto& [mote, counts] : expected_) {
    const auto& light = values(mote + ".light-1");
    const auto& temperature = values(mote + ".temperature-1");
    ASSERT_EQ(light.size(), counts.size()) << mote;
    ASSERT_EQ(temperature.size(), counts.size()) << mote;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      // wsn.md 11: PAR sensor at 1.5 V over 100 kOhm, 0.625e6 lux per mA; SHT11 at 3 V.
      EXPECT_NEAR(std::stod(light[i]), counts[i].first / 4096.0 * 1.5 / 100e3 * 0.625e6 * 1000, 0.051) << mote;
      EXPECT_NEAR(std::stod(temperature[i]), -39.6 + 0.01 * counts[i].second, 0.0051) << mote;
    }
  }
}

TEST_P(RecordedMotes, BecomeTuplesOfCountsThatRiseTogether) {
  play("raw", {"lightRaw-1", "temperatureRaw-1"});
  for (const auto& [mote, counts] : expected_) {
    std::vector<std::string> light, temperature;
    for (const auto& [light_count, temperature_count] : counts) {
      EXPECT_EQ(light_count - 300, 7 * (temperature_count - 6500)) << "the simulated ramp of the recording";
      light.push_back(std::to_string(light_count));
      temperature.push_back(std::to_string(temperature_count));
    }
    EXPECT_EQ(values(mote + ".lightRaw-1"), light) << mote;
    EXPECT_EQ(values(mote + ".temperatureRaw-1"), temperature) << mote;
  }
}

TEST_P(RecordedMotes, ShowAllTheyMeasuredWhateverIsWantedOfThem) {
  while_wanting("lightRaw-1", 10s);
  play("raw", {"lightRaw-1", "temperatureRaw-1"});
  for (const auto& [mote, counts] : expected_) {
    EXPECT_THAT(values(mote + ".lightRaw-1"), SizeIs(counts.size())) << mote;
    EXPECT_THAT(values(mote + ".temperatureRaw-1"), SizeIs(counts.size())) << mote;
  }
}

TEST_P(RecordedMotes, HaveWhatTheyDeclaredAndWhatTheyShowed) {
  play("physical", {});
  for (const auto& [mote, counts] : expected_) {
    const auto about = seen_json(GetParam().island, "proxy.wsn-1." + mote + ".description");
    for (const auto* sensor : {"motion-1", "microphoneRaw-1", "magnetic-1", "light-1", "temperature-1"})
      EXPECT_THAT(about.at("sensors").dump(), testing::HasSubstr(sensor)) << mote;
    EXPECT_THAT(about.at("actuators").dump(), testing::HasSubstr("led-1")) << mote;
  }
}

INSTANTIATE_TEST_SUITE_P(OfTheOriginalFirmware, RecordedMotes,
                         testing::Values(Recording{"avr_sf_tcp_rx", true, 11},
                                         Recording{"avr_sink_uart_mote2pc", false, 11},
                                         Recording{"origjava_uart_mote2pc", false, 12}),
                         [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace rubicon::scenarios
