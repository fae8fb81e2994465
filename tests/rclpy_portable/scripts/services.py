"""Three clients of one service; print whom a response wakes, and who takes it."""

import time

import rclpy
from rclpy.executors import SingleThreadedExecutor
from std_srvs.srv import SetBool, Trigger

rclpy.init(args=["--ros-args", "--disable-rosout-logs"])
server_node, *nodes = (rclpy.create_node(name) for name in ("server", "a", "b", "c"))
answers = []


def answer(request, response):
    response.success, response.message = True, f"answer {len(answers) + 1}"
    answers.append(response.message)
    return response


server = server_node.create_service(Trigger, "ask", answer)
other = server_node.create_service(SetBool, "set", lambda request, response: response)
clients = [node.create_client(Trigger, "ask") for node in nodes]
other_client = nodes[0].create_client(SetBool, "set")
for client in (*clients, other_client):
    print(client.srv_name, client.wait_for_service(timeout_sec=5))
executor = SingleThreadedExecutor()
executor.add_node(server_node)


def served(number):
    end = time.monotonic() + 5
    while len(answers) < number and time.monotonic() < end:
        executor.spin_once(timeout_sec=0.02)


def woken():
    context = rclpy.get_default_context().handle
    found = []
    for client in clients:
        with client.handle, context:
            waiting = rclpy.executors._rclpy.WaitSet(0, 0, 0, 1, 0, 0, context)
            waiting.clear_entities()
            index = waiting.add_client(client.handle)
            waiting.wait(0)
            found.append(waiting.is_ready("client", index))
    return found


def taken():
    found = []
    for client in clients:
        with client.handle:
            _, response = client.handle.take_response(Trigger.Response)
        found.append(response and response.message)
    return found


for asking in (0, 2, 1, 1):
    clients[asking].call_async(Trigger.Request())
    served(len(answers) + 1)
print(woken())
for _ in range(5):
    print(taken(), woken())
clients[0].call_async(Trigger.Request())
nodes[0].destroy_client(clients[0])
served(len(answers) + 1)  # it answers to nobody
print("served", len(answers))
rclpy.shutdown()
