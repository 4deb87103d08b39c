#include <gmock/gmock.h>

#include "config/engine_config.h"
#include "config/yaml.h"
#include "island/island_config.h"
#include "island/network_types.h"

namespace rubicon::config {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using tuples::dds::DdsTransport;

island::IslandConfig read(const std::string& tuples, base::ConfigErrors& errors) {
  const auto tree = parse_yaml("island: {id: 1}\ntuples: " + tuples + "\n", "home.yaml");
  return island::read_island_config(tree.value(), island::network_types(), errors);
}

EngineSetup good(const std::string& tuples) {
  base::ConfigErrors errors;
  auto engine = read(tuples, errors).engine;
  EXPECT_TRUE(errors.empty()) << tuples << ": " << errors.text();
  return engine;
}

TEST(EngineConfig, IsThisHostUnlessSaidOtherwise) {
  const auto unsaid = good("{}");
  EXPECT_TRUE(unsaid.host);
  EXPECT_FALSE(unsaid.dds);
  EXPECT_FALSE(unsaid.peis);
  EXPECT_TRUE(good("{engine: memory}").alone());
  EXPECT_TRUE(good("{engine: memory, host: no}").alone());
  const auto named = good("{engine: host, space: lab.2, folder: /srv/meet, lease: 3s}");
  EXPECT_TRUE(named.host);
  EXPECT_EQ(named.space, "lab.2");
  EXPECT_EQ(named.folder, "/srv/meet");
  EXPECT_EQ(named.options.lease, std::chrono::seconds(3));
}

TEST(EngineConfig, InterfacesAddDdsWhereNoEngineIsNamed) {
  for (const auto* with : {"{interfaces: eth0}", "{interfaces: lo}", "{engine: dds}", "{transport: tcp, port: 7500}"}) {
    EXPECT_TRUE(good(with).host) << with;
    EXPECT_TRUE(good(with).dds) << with;
  }
  EXPECT_FALSE(good("{engine: peis, interfaces: eth0}").dds) << "peis has interfaces too";
  EXPECT_TRUE(good("{engine: peis, interfaces: eth0}").host);
  const auto distant = good("{host: no, interfaces: eth0}");
  EXPECT_FALSE(distant.host);
  EXPECT_EQ(distant.options.interfaces, std::vector<std::string>{"eth0"});
  for (const auto* without : {"{trust: no}", "{trust: yes}"}) EXPECT_FALSE(good(without).dds) << without;
}

/// Files of earlier releases.
TEST(EngineConfig, ADomainAndATagWithoutInterfacesBecomeASpace) {
  const auto both = good("{domain: 3, tag: lab_2}");
  EXPECT_FALSE(both.dds);
  EXPECT_EQ(both.space, "d3-lab_2");
  EXPECT_THAT(both.warnings,
              ElementsAre("home.yaml:2:26: tuples.tag: without interfaces this is the space of this host, expected "
                          "space: d3-lab_2"));
  EXPECT_EQ(good("{domain: 3}").space, "d3");
  EXPECT_EQ(good("{tag: x}").space, "d0-x");
  const auto lan = good("{domain: 3, tag: x, interfaces: eth0}");
  EXPECT_EQ(lan.space, "");
  EXPECT_EQ(lan.options.tag, "x");
  EXPECT_THAT(lan.warnings, testing::IsEmpty());
  EXPECT_THAT(good("{trust_lan: yes}").warnings,
              ElementsAre(HasSubstr("tuples.trust_lan: without interfaces no other host")));
}

TEST(EngineConfig, TakesAllThatDdsNeeds) {
  const auto lan = good("{domain: 7, interfaces: [eth0, wlan0.5], tag: lab_2, lease: 3s, trust_lan: yes}").options;
  EXPECT_EQ(lan.domain, 7U);
  EXPECT_THAT(lan.interfaces, ElementsAre("eth0", "wlan0.5"));
  EXPECT_FALSE(is_loopback_only(lan));
  EXPECT_EQ(lan.tag, "lab_2");
  EXPECT_EQ(lan.lease, std::chrono::seconds(3));
  EXPECT_TRUE(lan.trust_lan);
  EXPECT_THAT(good("{interfaces: eth0, peers: [10.0.0.7, robot.lan, \"desk:7410\"]}").options.peers,
              ElementsAre("10.0.0.7", "robot.lan", "desk:7410"));
  const auto tcp = good("{interfaces: eth0, transport: tcp, port: 7500, peers: [\"10.0.0.7:7501\"]}").options;
  EXPECT_EQ(tcp.transport, DdsTransport::kTcp);
  EXPECT_EQ(tcp.port, 7500);
  EXPECT_TRUE(good("{engine: dds, trust_lan: yes}").options.trust_lan) << "on loopback too";
}

TEST(EngineConfig, TakesPeisAloneOrBesideDds) {
  const auto both = good("{engine: [dds, peis]}");
  EXPECT_TRUE(both.dds);
  EXPECT_TRUE(both.peis);
  EXPECT_EQ(both.peis_options, tuples::peis::PeisOptions());
  const auto alone = good(
      "{engine: peis, interfaces: eth0, lease: 3s, trust_lan: yes, peis: {network: lab, listen: 8100, "
      "connect: [\"tcp://10.0.0.7:8000\", robot.lan], multicast: no}}");
  EXPECT_FALSE(alone.dds);
  ASSERT_TRUE(alone.peis);
  const tuples::peis::PeisOptions expected{
      "lab", 8100, {"10.0.0.7:8000", "robot.lan"}, false, {"eth0"}, std::chrono::seconds(3), true};
  EXPECT_EQ(alone.peis_options, expected);
  EXPECT_FALSE(good("{}").peis);
}

TEST(EngineConfig, TakesWhatIsCarriedBetweenTwoEngines) {
  EXPECT_TRUE(good("{engine: [dds, peis]}").carry.empty());
  const auto carry = good("{engine: [dds, peis], peis: {carry: [4711, kitchen.**, \"*.name\"]}}").carry;
  ASSERT_EQ(carry.rules.size(), 1U);
  EXPECT_THAT(carry.rules[0].ids, ElementsAre(OwnerId(4711)));
  EXPECT_THAT(carry.rules[0].patterns, ElementsAre("kitchen.**", "*.name"));
  EXPECT_TRUE(carry.carries_any_of(OwnerId(7), {"peis", "dds"}));
  EXPECT_FALSE(carry.carries_any_of(OwnerId(7), {"host", "peis"})) << "as before there was engine host";
  EXPECT_FALSE(good("{engine: [dds, peis], trust: no, peis: {carry: [2]}}").carry.empty());
  EXPECT_THAT(good("{engine: [dds, peis], peis: {carry: kitchen.**}}").carry.rules[0].patterns,
              ElementsAre("kitchen.**"));
}

TEST(EngineConfig, TakesWhatIsCarriedBetweenSomeOrAllEngines) {
  const auto all = good("{engine: dds, carry: [4711, kitchen.**]}").carry;
  EXPECT_TRUE(all.carries_any_of(OwnerId(7), {"host", "dds"}));
  EXPECT_TRUE(all.carries(OwnerId(4711), "hall.lamp", {"dds", "host"}));
  EXPECT_FALSE(all.carries(OwnerId(7), "hall.lamp", {"dds", "host"}));
  const auto site = good(
      "{engine: [dds, mqtt], mqtt: {broker: b}, carry: [{what: 4711, from: dds, to: mqtt}, {what: [\"a.**\", 8], from: "
      "mqtt, to: [dds, host]}]}");
  EXPECT_THAT(carried(site.carry), ElementsAre("component 4711 from dds to mqtt",
                                               "component 8, a.** of every component from mqtt to dds or host"));
  EXPECT_TRUE(site.carry.carries_any_of(OwnerId(4711), {"dds", "mqtt"}));
  EXPECT_FALSE(site.carry.carries(OwnerId(4711), "b", {"mqtt", "dds"}));
  EXPECT_FALSE(site.carry.carries_any_of(OwnerId(4711), {"host", "mqtt"}));
}

TEST(EngineConfig, ABrokerAddsTheSpaceOfSites) {
  EXPECT_FALSE(good("{}").mqtt);
  const auto site = good(
      "{mqtt: {broker: {host: b, tls: yes, user: hall}, space: city, lease: 1min, trust_broker: yes, "
      "watch: all, spare_brokers: [c, \"[::1]:9002\"]}}");
  EXPECT_TRUE(site.mqtt && site.host && !site.dds);
  EXPECT_EQ(site.mqtt_space.broker.line.port, 8883);
  EXPECT_EQ(site.mqtt_space.broker.line.user, "hall");
  EXPECT_EQ(site.mqtt_space.space, "city");
  EXPECT_EQ(site.mqtt_space.lease, std::chrono::minutes(1));
  EXPECT_TRUE(site.mqtt_space.trust_broker);
  EXPECT_TRUE(site.mqtt_space.watch_all);
  EXPECT_THAT(site.mqtt_space.spare, testing::ElementsAre(base::HostPort{"c", 8883}, base::HostPort{"::1", 9002}));
  const auto alone = good("{host: no, engine: mqtt, mqtt: {broker: \"10.0.0.1:1884\"}}");
  EXPECT_TRUE(alone.mqtt && !alone.host && !alone.alone());
  EXPECT_EQ(alone.mqtt_space.broker.line.port, 1884);
  EXPECT_FALSE(alone.mqtt_space.trust_broker);
  EXPECT_FALSE(alone.mqtt_space.watch_all);
}

TEST(EngineConfig, KnowsWhoHadCertificatesAndWhoWantsNone) {
  EXPECT_EQ(good("{}").old_trust, OldTrust::kUnsaid);
  for (const auto* had : {"{trust: yes}", "{trust: /srv/trust}", "{engine: [dds, peis], trust: ./trust}"})
    EXPECT_EQ(good(had).old_trust, OldTrust::kYes) << had;
  const auto open = good("{trust: no, trust_lan: yes, interfaces: eth0}");
  EXPECT_EQ(open.old_trust, OldTrust::kNo);
  EXPECT_TRUE(open.trust_lan);
  EXPECT_FALSE(good("{interfaces: eth0}").trust_lan);
}

TEST(EngineConfig, SaysWhereAndWhatIsWrong) {
  const std::string long_tag(65, 'x'), long_name(16, 'e');
  const std::pair<std::string, std::string> cases[] = {
      {"{engine: zenoh}", "home.yaml:2:18: tuples.engine: is 'zenoh', expected one of: memory, host, dds, mqtt, peis"},
      {"{engine: mqtt}", "home.yaml:2:18: tuples.engine: mqtt needs a broker, expected mqtt: {broker: HOST} too"},
      {"{engine: host, mqtt: {broker: b}}", "home.yaml:2:30: tuples.mqtt: only engine mqtt has these options"},
      {"{mqtt: {}}", "tuples.mqtt: 'broker' is missing, expected HOST[:PORT] of the MQTT broker, or a map"},
      {"{mqtt: {broker: {host: b, user: a/b}}}", "tuples.mqtt.broker: the user name 'a/b' has a '/', expected none of"},
      {"{mqtt: {broker: {host: b, user: peis}}}", "tuples.mqtt.broker: 'peis' is not a user name"},
      {"{mqtt: {broker: b, space: a/b}}", "tuples.mqtt.space: expected 1 to 64 of"},
      {"{mqtt: {broker: b, watch: some}}", "tuples.mqtt.watch: is 'some', expected one of: met, all"},
      {"{mqtt: {broker: b, spare_brokers: [\"c:0\"]}}", "tuples.mqtt.spare_brokers: has 'c:0', expected HOST[:PORT]"},
      {"{mqtt: {broker: b, spare_brokers: [c, d, e, f, g, h, i, j, k]}}",
       "tuples.mqtt.spare_brokers: expected at most 8"},
      {"{mqtt: {broker: b, lease: 5s}}", "tuples.mqtt.lease: expected from 13s to 10min"},
      {"{mqtt: {broker: b, trust: yes}}", "tuples.mqtt: unknown key 'trust'"},
      {"{engine: [dds, dds]}", "home.yaml:2:24: tuples.engine[1]: 'dds' is listed twice"},
      {"{engine: []}", "tuples.engine: expected memory, or one or more of: host, dds, mqtt, peis"},
      {"{engine: [memory, peis]}", "tuples.engine: memory cannot be combined"},
      {"{engine: peis, domain: 3}", "tuples.domain: only engine dds has this option; for PEIS peis.network decides"},
      {"{engine: peis, port: 3}", "tuples.port: only engine dds has this option; for PEIS peis.listen is the port"},
      {"{peis: {listen: 8000}}", "tuples.peis: only engine peis has these options"},
      {"{engine: peis, peis: {listen: 70000}}", "tuples.peis.listen: is '70000', expected a whole number from 0"},
      {"{engine: peis, peis: {network: \"\"}}", "tuples.peis.network: expected 1 to 63 characters"},
      {"{engine: peis, peis: {connect: [a, \"udp://b:1\"]}}", "tuples.peis.connect[1]: expected tcp://host:port"},
      {"{engine: peis, peis: {connect: [localhost, \"tcp://10.9.9.1:9999\"]}}",
       "home.yaml:2:52: tuples.peis.connect[1]: lo reaches no other host, expected another interface too"},
      {"{engine: peis, peis: {carry: [2]}}",
       "home.yaml:2:38: tuples.peis.carry: needs two engines to carry between, expected engine: [dds, peis]"},
      {"{engine: host, carry: [2]}", "tuples.carry: needs two engines to carry between, expected engine too"},
      {"{engine: dds, carry: []}", "tuples.carry: has 0 entries, expected 1 to 1000"},
      {"{engine: dds, carry: {what: 2}}", "tuples.carry: is a map, expected a list"},
      {"{engine: dds, carry: [{from: dds}]}", "home.yaml:2:31: tuples.carry[0]: 'what' is missing, expected ids"},
      {"{engine: dds, carry: [{what: []}]}", "tuples.carry[0].what: has 0 entries"},
      {"{engine: dds, carry: [{what: [2, a..b]}]}", "tuples.carry[0].what[1]: expected the id of a component, or a"},
      {"{engine: dds, carry: [2, 1]}", "tuples.carry[1]: 1 is this island, which is on all its engines anyway"},
      {"{engine: dds, carry: [{what: 2, to: mqtt}]}",
       "carry[0].to: is 'mqtt', expected an engine of this island: host"},
      {"{engine: dds, carry: [{what: 2, from: dds, to: dds}]}",
       "carry[0].to: is where it comes from, expected another"},
      {"{engine: dds, carry: [{what: 2, over: dds}]}", "tuples.carry[0]: unknown key 'over'"},
      {"{engine: [dds, peis], carry: [2], peis: {carry: [3]}}", "tuples.peis.carry: tuples.carry is there too"},
      {"{engine: [dds, peis], peis: {carry: []}}", "tuples.peis.carry: has 0 entries, expected 1 to 1000"},
      {"{engine: [dds, peis], peis: {carry: [2, a..b]}}",
       "home.yaml:2:49: tuples.peis.carry[1]: expected the id of a component, or a pattern of keys such as kitchen.**"},
      {"{engine: [dds, peis], peis: {carry: [0]}}", "expected the id of a component, 1 to 2147483647"},
      {"{engine: [dds, peis], peis: {carry: [2, -5]}}",
       "home.yaml:2:49: tuples.peis.carry[1]: is '-5', expected the id of a component, 1 to 2147483647"},
      {"{engine: [dds, peis], peis: {carry: 3.0}}", "tuples.peis.carry: is '3.0', expected the id of a component"},
      {"{engine: [dds, peis], peis: {carry: [\"7:a\"]}}", "expected an id or a pattern, not both"},
      {"{engine: [dds, peis], peis: {carry: [2, 1]}}",
       "carry[1]: 1 is this island, which is on all its engines anyway"},
      {"{engine: [dds, peis], peis: {carry: [01]}}",
       "carry[0]: is '01', expected the id of a component, 1 to 2147483647"},
      {"{engine: [dds, peis], peis: {carry: [2, 2]}}", "carry[1]: '2' is listed twice"},
      {"{engine: [dds, peis], peis: {carry: [a.*, a.*]}}", "carry[1]: 'a.*' is listed twice"},
      {"{domain: 231}", "home.yaml:2:18: tuples.domain: is '231', expected a whole number from 0 to 230"},
      {"{lease: 100ms}", "home.yaml:2:17: tuples.lease: expected from 500ms to 60s"},
      {"{lease: 61s}", "tuples.lease: expected from 500ms to 60s"},
      {"{engine: memory, tag: lab}", "home.yaml:2:31: tuples.tag: only engine dds has this option"},
      {"{engine: memory, trust_lan: yes}", "tuples.trust_lan: only engines dds and peis have this option"},
      {"{interfaces: []}", "home.yaml:2:22: tuples.interfaces: has 0 names, expected 1 to 4 names"},
      {"{interfaces: [a, b, c, d, e]}", "has 5 names, expected 1 to 4"},
      {"{interfaces: [eth0, eth0]}", "home.yaml:2:29: tuples.interfaces[1]: 'eth0' is listed twice"},
      {"{interfaces: [eth0, lo]}", "home.yaml:2:29: tuples.interfaces[1]: lo cannot be combined"},
      {"{interfaces: [\"eth 0\"]}", "home.yaml:2:23: tuples.interfaces[0]: expected the name of a network interface"},
      {"{interfaces: " + long_name + "}", "tuples.interfaces: expected the name of a network interface"},
      {"{peers: [a]}", "home.yaml:2:17: tuples.peers: lo reaches no other host, expected another interface too"},
      {"{interfaces: eth0, peers: [a, \"b c\"]}", "home.yaml:2:39: tuples.peers[1]: expected host or host:port"},
      {"{interfaces: eth0, peers: [\"<x>\"]}", "expected host or host:port"},
      {"{interfaces: eth0, peers: [\"a:0\"]}", "expected a port from 1 to 65535"},
      {"{interfaces: eth0, peers: [\"a:99999\"]}", "expected a port from 1 to 65535"},
      {"{interfaces: eth0, peers: [\"a:\"]}", "expected a port from 1 to 65535"},
      {"{transport: tcp, peers: [a]}", "expected host:port: over tcp every process has a port of its own"},
      {"{transport: tcp}",
       "home.yaml:2:21: tuples.transport: tcp does not discover components by itself, expected port or peers"},
      {"{transport: sctp}", "expected one of: udp, tcp"},
      {"{port: 7500}", "home.yaml:2:16: tuples.port: only transport tcp has this option"},
      {"{tag: " + long_tag + "}", "tuples.tag: expected at most 64 of A-Z a-z 0-9 . _ -"},
      {"{tag: \"a<b\"}", "tuples.tag: expected at most 64"},
      {"{trust_lan: perhaps}", "home.yaml:2:21: tuples.trust_lan: is 'perhaps', expected yes or no"},
      {"{trust: perhaps}", "home.yaml:2:17: tuples.trust: is 'perhaps', expected no: this release has no certificates"},
      {"{trust-lan: yes}", "tuples: unknown key 'trust-lan'; did you mean 'trust_lan'? known: carry, domain, engine"},
      {"{host: no}", "home.yaml:2:16: tuples.host: leaves no engine, expected engine too: dds, mqtt, peis, or memory"},
      {"{engine: memory, host: yes}", "tuples.host: memory cannot be combined with others"},
      {"{engine: memory, lease: 2s}", "tuples.lease: engine memory has no such option"},
      {"{engine: memory, space: a}", "tuples.space: only engine host has this option"},
      {"{host: no, engine: dds, folder: /srv}", "tuples.folder: only engine host has this option"},
      {"{engine: host, interfaces: eth0}", "tuples.interfaces: only engines dds and peis have this option"},
      {"{engine: host, tag: x}", "tuples.tag: only engine dds has this option"},
      {"{space: a/b}", "home.yaml:2:17: tuples.space: 'a/b' is not a space, expected 1 to 40 characters of A-Z"},
      {"{folder: meet}", "home.yaml:2:18: tuples.folder: is 'meet', expected an absolute path"},
      {"{space: a, tag: b}", "tuples.tag: only engine dds has this option, and there is a space"},
      {"{tag: " + std::string(50, 'x') + "}", "tuples.tag: cannot become a space of this host"},
  };
  for (const auto& [text, part] : cases) {
    base::ConfigErrors errors;
    read(text, errors);
    EXPECT_THAT(errors.text(), HasSubstr(part)) << text;
  }
}

TEST(EngineConfig, AnOptionOfAnotherEngineIsOneError) {
  for (const auto* tuples : {"{engine: peis, peers: [robot]}", "{engine: peis, transport: tcp}",
                             "{engine: memory, port: 7500}", "{engine: peis, domain: 231}"}) {
    base::ConfigErrors errors;
    read(tuples, errors);
    EXPECT_THAT(errors.lines(), ElementsAre(HasSubstr("only engine dds has this option"))) << tuples;
  }
}

TEST(EngineConfig, LoConnectsToThisHostOnly) {
  const auto here = good("{engine: peis, peis: {connect: [\"tcp://127.0.0.2:8001\", localhost, robot.lan]}}");
  EXPECT_THAT(here.peis_options.connect, ElementsAre("127.0.0.2:8001", "localhost", "robot.lan"));
  EXPECT_THAT(good("{engine: peis, interfaces: eth0, peis: {connect: 10.9.9.1}}").peis_options.connect,
              ElementsAre("10.9.9.1"));
}

TEST(EngineConfig, TheHostsToAskAreNotWithoutBound) {
  std::string hosts;
  for (int i = 0; i < 65; ++i) hosts += (i ? ", h" : "h") + std::to_string(i);
  base::ConfigErrors errors;
  read("{interfaces: eth0, peers: [" + hosts + "]}", errors);
  EXPECT_THAT(errors.text(), HasSubstr("tuples.peers: has 65 hosts, expected at most 64"));
}

}  // namespace
}  // namespace rubicon::config
