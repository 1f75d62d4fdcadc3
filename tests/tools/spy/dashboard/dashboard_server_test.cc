#include "tools/spy/dashboard/dashboard_server.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/dashboard_spy.h"
#include "tools/spy/dashboard/request_origin.h"
#include "tools/spy/dashboard/request_server.h"

/// Tests the answers of `hpdm spy --web` without a browser.

namespace hpdm {
namespace {

using nlohmann::json;

httplib::Headers With(const std::string& name, const std::string& value) { return {{name, value}}; }

int Connect(int port) {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  return fd;
}

void Send(int fd, const std::string& text) {
  EXPECT_EQ(send(fd, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
}

// Returns all bytes until the server closes the connection.
std::string Rest(int fd) {
  std::string text;
  char buffer[4096];
  for (ssize_t got; (got = recv(fd, buffer, sizeof buffer, 0)) > 0;) {
    text.append(buffer, static_cast<std::size_t>(got));
  }
  return text;
}

// Returns a member's first value for a viewer; null if the first updates lack it.
json FirstUpdateWith(const char* member, int port) {
  httplib::Client client("127.0.0.1", port);
  std::string text;
  int left = 30;
  json found;
  client.Get("/events", [&](const char* data, std::size_t size) {
    text.append(data, size);
    for (std::size_t end; (end = text.find("\n\n")) != std::string::npos;) {
      const std::string line = text.substr(0, end);
      text.erase(0, end + 2);
      if (!line.starts_with("data: ")) continue;
      --left;
      const json update = json::parse(line.substr(6));
      if (update.contains(member)) found = update;
    }
    return found.is_null() && left > 0;
  });
  return found;
}

TEST(DashboardServer, IsReachedByThisMachineAloneUnlessAskedOtherwise) {
  DashboardOptions options;
  options.port = 0;
  // 127.0.0.2 is this machine too, by an address that the default does not listen on.
  const auto reached = [&options] {
    const DashboardServer server(options, "a test", true);
    return httplib::Client("127.0.0.2", server.port()).Get("/").error() == httplib::Error::Success;
  };
  EXPECT_FALSE(reached());
  options.host = "0.0.0.0";
  EXPECT_TRUE(reached());
}

TEST(DashboardServer, RefusesOtherSites) {
  DashboardServer server({"127.0.0.1", 0}, "a test", true);
  httplib::Client client("127.0.0.1", server.port());
  const std::string own = "http://127.0.0.1:" + std::to_string(server.port());
  const std::string seek = R"({"command": "seek", "value": 1})";
  EXPECT_EQ(client.Get("/")->status, 200);
  EXPECT_NE(client.Get("/")->get_header_value("Content-Security-Policy").find("default-src 'none'"),
            std::string::npos);
  EXPECT_EQ(client.Get("/", With("Host", "localhost:" + std::to_string(server.port())))->status,
            200);
  EXPECT_EQ(client.Get("/", With("Host", "[::1]:1"))->status, 200);
  for (const char* host : {"evil.example", "evil.example:8090", "127.0.0.1.evil.example", ""}) {
    EXPECT_EQ(client.Get("/", With("Host", host))->status, 403) << host;
    EXPECT_EQ(client.Get("/mesh/0", With("Host", host))->status, 403) << host;
  }
  const auto post = [&](const httplib::Headers& headers, const std::string& body,
                        const char* type = "application/json") {
    return client.Post("/control", headers, body, type)->status;
  };
  EXPECT_EQ(post(With("Origin", "http://evil.example"), seek), 403);
  EXPECT_EQ(post(With("Origin", "null"), seek), 403);
  EXPECT_EQ(post(With("Origin", "http://127.0.0.1:1"), seek), 403) << "another port";
  EXPECT_EQ(post(With("Sec-Fetch-Site", "cross-site"), seek), 403);
  EXPECT_EQ(client.Get("/events", With("Origin", "http://evil.example"))->status, 403);
  EXPECT_EQ(post({}, seek, "text/plain"), 400) << "what a form of another site can send";
  EXPECT_TRUE(server.TakeCommands().empty());
  for (const char* body :
       {"", "{", "[]", R"({"command": 1})", R"({"command": "seek"})",
        R"({"command": "seek", "value": -1})", R"({"command": "speed", "value": 0})",
        R"({"command": "seek", "value": "1"})", R"({"command": "stop"})"}) {
    EXPECT_EQ(post({}, body), 400) << body;
  }
  EXPECT_TRUE(server.TakeCommands().empty());
  EXPECT_EQ(post(With("Origin", own), seek), 204);
  const std::vector<PlayerCommand> commands = server.TakeCommands();
  ASSERT_EQ(commands.size(), 1u);
  EXPECT_EQ(commands[0].kind, PlayerCommand::kSeek);
  EXPECT_EQ(commands[0].value, 1);
  EXPECT_EQ(client.Get("/mesh/0")->status, 404);
  EXPECT_EQ(client.Get("/../../etc/passwd")->status, 404);
}

TEST(DashboardServer, ALiveSessionTakesNoCommands) {
  DashboardServer server({"127.0.0.1", 0}, "a test", false);
  httplib::Client client("127.0.0.1", server.port());
  EXPECT_EQ(client.Post("/control", R"({"command": "pause"})", "application/json")->status, 400);
  EXPECT_TRUE(server.TakeCommands().empty());
}

TEST(DashboardServer, AStalledViewerHoldsUpNoOther) {
  auto server = std::make_unique<DashboardServer>(DashboardOptions{"127.0.0.1", 0}, "a test", true);
  std::vector<int> stalled;
  for (int i = 0; i < DashboardServer::kMaxViewers - 1; ++i) {
    stalled.push_back(Connect(server->port()));
    Send(stalled.back(), "GET /events HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  }
  std::jthread reader([&server](std::stop_token stop) {
    // Shapes large enough to fill every buffer on the way within a few updates.
    organ_t shape{};
    mesh_t mesh{};
    OrganDescription description;
    description.name = "cloud";
    description.vertices = Points::Random(20'000, 3);
    LogEvent event;
    for (const mesh_t& part : SplitMesh(0, description)) {
      event.channel = kMeshChannel;
      EncodeMessage(part, &event.data);
      server->Take(event);
    }
    shape.displacements.assign(60'000, 0.5f);
    shape.value_count = 60'000;
    while (!stop.stop_requested()) {
      ++shape.sequence;
      event.channel = kOrganChannel;
      EncodeMessage(shape, &event.data);
      server->Take(event);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  });
  httplib::Client client("127.0.0.1", server->port());
  int updates = 0;
  // Only so many arrive when nothing holds them up: the test's time limit is the bound.
  client.Get("/events", [&updates](const char* data, std::size_t size) {
    for (const char c : std::string_view(data, size)) updates += c == '\n';
    return updates < 100;
  });
  EXPECT_GE(updates, 100);
  const auto refused = client.Get("/mesh/0");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 200) << "requests have threads besides the viewers'";
  reader.request_stop();
  reader.join();
  server.reset();  // ends with the stalled streams open
  for (const int fd : stalled) close(fd);
}

TEST(DashboardServer, SaysThatItsPortIsInUse) {
  const DashboardServer first({"127.0.0.1", 0}, "a test", true);
  Spy second(TwoHandsLog(), first.port());
  EXPECT_EQ(second.child().Wait(10), 3);
  const std::string errors = second.errors();
  EXPECT_NE(errors.find("the port is in use; choose another"), std::string::npos) << errors;
  EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 1) << errors;
}

// A page of another site sends a request whose body is a whole request of its own, a little later
// than its head, to a server that has refused the head by then.
TEST(DashboardServer, TakesNoBodyForARequest) {
  DashboardServer server({"127.0.0.1", 0}, "a test", true);
  const std::string seek = R"({"command": "seek", "value": 1})";
  const std::string inner =
      "POST /control HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
      "Content-Length: " +
      std::to_string(seek.size()) + "\r\n\r\n" + seek;
  const int fd = Connect(server.port());
  Send(fd,
       "POST /control HTTP/1.1\r\nHost: 127.0.0.1\r\nOrigin: http://evil.example\r\n"
       "Content-Type: text/plain\r\nContent-Length: " +
           std::to_string(inner.size()) + "\r\n\r\n");
  std::string answer(12, ' ');
  ASSERT_EQ(recv(fd, answer.data(), answer.size(), MSG_WAITALL), 12);
  EXPECT_EQ(answer, "HTTP/1.1 403");
  Send(fd, inner);
  EXPECT_EQ(Rest(fd).find("HTTP/1.1"), std::string::npos) << "a second answer";
  close(fd);
  EXPECT_TRUE(server.TakeCommands().empty());
}

// More clients than threads that never finish their request, and one that sends nothing.
TEST(DashboardServer, EndsWhateverItsClientsDo) {
  std::vector<int> clients;
  {
    DashboardServer server({"127.0.0.1", 0}, "a test", true);
    for (int i = 0; i < 27; ++i) {
      clients.push_back(Connect(server.port()));
      if (i > 0) Send(clients.back(), "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: ");
    }
  }
  // A client that the server waited for would have got the error of a bad request.
  for (const int fd : clients) {
    EXPECT_EQ(Rest(fd), "");
    close(fd);
  }
}

TEST(RequestServer, WaitsForNoSlowRequest) {
  RequestServer server(std::chrono::milliseconds(50));
  const int port = server.bind_to_any_port("127.0.0.1");
  std::jthread listener([&server] { server.listen_after_bind(); });
  const int fd = Connect(port);
  std::string text = "GET / HTTP/1.1\r\nX: ";
  int sent = 0;
  // Each byte comes well before a wait of 50 ms for it ends; 1000 of them do not.
  for (; sent < 1000 && recv(fd, text.data(), 1, MSG_DONTWAIT) < 0; ++sent) {
    send(fd, text.data() + std::min<std::size_t>(sent, text.size() - 1), 1, MSG_NOSIGNAL);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_LT(sent, 1000);
  close(fd);
  server.stop();
  server.EndConnections();
}

TEST(DashboardServer, BoundsWhatARequestMayTake) {
  DashboardServer server({"127.0.0.1", 0}, "a test", true);
  const int fd = Connect(server.port());
  std::string head = "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n";
  while (head.size() < 2 * RequestServer::kMaxRequestBytes) head += "X: 0123456789\r\n";
  send(fd, head.data(), head.size(), MSG_NOSIGNAL);  // may fail: the server closes
  EXPECT_EQ(Rest(fd).find("HTTP/1.1 200"), std::string::npos);
  close(fd);
}

TEST(DashboardServer, KnowsItsNames) {
  EXPECT_TRUE(MeansThisServer("myhost:8090", "MyHost"));
  EXPECT_TRUE(MeansThisServer("LOCALHOST:1", "127.0.0.1"));
  EXPECT_FALSE(MeansThisServer("192.168.0.7:8090", "127.0.0.1"));
  for (const char* all : {"0.0.0.0", "::"}) {
    EXPECT_TRUE(MeansThisServer("192.168.0.7:8090", all));
    EXPECT_FALSE(MeansThisServer("evil.example:8090", all));
    for (const std::string& name : NamesOfMachine()) {
      EXPECT_TRUE(MeansThisServer(name + ":8090", all)) << name;
      EXPECT_FALSE(MeansThisServer(name + ":8090", "127.0.0.1")) << name;
    }
  }
  const DashboardServer server({"0.0.0.0", 0}, "a test", true);
  EXPECT_EQ(server.address(), "http://127.0.0.1:" + std::to_string(server.port()) + "/");
}

// A log has meshes and names at its start only. An argument after --web that is not a port is the
// log.
TEST(DashboardServer, SendsTheMeshesAndNamesBeforeItsStart) {
  Spy spy(Spy::Arguments{"--from 2.5 --web " + TwoHandsLog()});
  ASSERT_FALSE(spy.address().empty()) << spy.errors();
  const json update = FirstUpdateWith("meshes", spy.port());
  ASSERT_TRUE(update.is_object());
  EXPECT_EQ(update["meshes"][0]["name"], "liver");
  EXPECT_EQ(update["instruments"], json({"probe", "grasper"}));
  EXPECT_EQ(update["events"][0]["name"], "session.start");
}

// The second last time stamp is damaged: rates use the log's played time.
TEST(DashboardServer, CountsRatesByThePlayedTime) {
  const ScratchFolder folder;
  const std::string log = folder / "damaged.lcmlog";
  {
    SessionLog copy(log, 0);
    LogReader reader(TwoHandsLog());
    int left = 0;
    for (LogEvent event; reader.Next(&event);) ++left;
    LogReader again(TwoHandsLog());
    for (LogEvent event; again.Next(&event); --left) {
      copy.Append(event.channel.c_str(), left == 2 ? std::int64_t{1} << 61 : event.time_us,
                  event.data);
    }
    copy.Close();
  }
  Spy spy(log, 0, "--from 2.99 --speed 100");
  ASSERT_FALSE(spy.address().empty()) << spy.errors();
  json update;
  // The server updates the page once a second; the log ends at once.
  for (int i = 0; i < 50 && !update.is_object(); ++i) {
    update = FirstUpdateWith("channels", spy.port());
    if (!update["status"]["player"]["ended"].get<bool>()) update = nullptr;
  }
  ASSERT_TRUE(update.is_object());
  for (const json& channel : update["channels"]) {
    if (channel["channel"] != kForceChannel) continue;
    EXPECT_NEAR(channel["rate_hz"].get<double>(), 1000, 1);
  }
}

TEST(DashboardServer, RefusesAnInvalidPort) {
  for (const char* value : {"70000", "123456789012", "nothing"}) {
    Spy spy(Spy::Arguments{TwoHandsLog() + " --web " + value});
    EXPECT_EQ(spy.child().Wait(10), 2) << value;
    EXPECT_NE(spy.errors().find("from 0 to 65535"), std::string::npos) << spy.errors();
  }
}

}  // namespace
}  // namespace hpdm
