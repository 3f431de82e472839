"""Cycles of references: a depth-first walk of a graph of a million nodes without recursion."""

import cython
import numpy as np


def cycles(offsets: cython.longlong[::1], targets: cython.longlong[::1], most: cython.int) -> list:
    """Return up to `most` cycles of a directed graph, each as the list of its nodes in order.

    A node that stands on the walk's own stack closes a cycle, and a graph without such a back edge has none (T. H. Cormen,
    C. E. Leiserson, R. L. Rivest and C. Stein (2009), Lemma 22.11); every cycle of the graph that is reported this way is
    real, and at least one is reported of a graph that has any.

    Args:
        offsets: Shape (n + 1,): the edges of node i are ``targets[offsets[i]:offsets[i + 1]]``.
        targets: Nodes.
        most: How many to report.
    """
    n: cython.Py_ssize_t = offsets.shape[0] - 1
    node: cython.Py_ssize_t
    root: cython.Py_ssize_t
    top: cython.Py_ssize_t
    to: cython.Py_ssize_t
    state: cython.schar[::1] = np.zeros(n, np.int8)  # 0 not met, 1 on the stack, 2 left
    edge: cython.longlong[::1] = np.array(offsets[:n], np.int64)
    stack: cython.longlong[::1] = np.zeros(n + 1, np.int64)
    found: list = []
    for root in range(n):
        if state[root]:
            continue
        top = 0
        stack[0] = root
        state[root] = 1
        while top >= 0:
            node = stack[top]
            if edge[node] >= offsets[node + 1]:
                state[node] = 2
                top -= 1
                continue
            to = targets[edge[node]]
            edge[node] += 1
            if state[to] == 0:
                top += 1
                stack[top] = to
                state[to] = 1
            elif state[to] == 1:
                begin: cython.Py_ssize_t = top
                while stack[begin] != to:
                    begin -= 1
                found.append([int(stack[k]) for k in range(begin, top + 1)])
                if len(found) >= most:
                    return found
    return found
