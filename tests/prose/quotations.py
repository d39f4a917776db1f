"""The thesis's own words, to the letter, wherever the book quotes them."""

#: Sentence, or the part that is quoted: where the thesis has it.
QUOTATIONS = {
    "to ensure an LMI condition over an entire polytopic uncertain domain, it "
    "suffices to check the LMI at the vertices of the convex polytope": "section 2.3, proof of Lemma 2.1",
    "it suffices to check the LMIs at the vertices of the convex polytope": "section 2.4.2, proof of Theorem 2.2",
    "to guarantee an LMI in a polytope domain, it is sufficient to check the "
    "LMI on its vertices of the polytope": "section 2.4.5, proof of Theorem 2.4",
    "if and only if": "Theorem 2.2",
    "robustly stable": "Theorems 2.1, 2.4 and 2.5",
    "for an appropriated binary matrix": "section 2.2",
    "a conic sector centered at the origin and with inner angle given by": "Examples 1 to 4, specifications",
    "small impacts are observed on the dynamic response of the system for "
    "different values of the driver-plus-seat mass": "Example 2",
    "Fig. 3.8 shows the control signal, where we can see that it does not "
    "exceed the limit": "Example 2",
    "to a unity set point": "Examples 1 to 3",
    "for a unity set-point": "section 3.2, Example 1",
    "to a constant set-point": "section 3.2, Example 2",
    "to a piece-wise constant set-point": "Example 4",
    "this system presents an impulsive behavior due to an open-loop pole at "
    "infinite": "Example 3",
    "is respected for a given perturbation": "Examples 1 and 3",
    "the reference tracking depicts the expected response despite the "
    "nonlinear effect induced by the significant excursion range beyond the "
    "original rest positioning": "Example 4",
    "the friction between the wheels and the ground is zero": "section 4.1",
    "is a stable equilibrium, which is reached without any control": "section 4.1.1",
    "obtain only an approximation": "section 4.2.1",
    "by varying R, noise and control effort decrease": "section 4.3.1",
    "the response is less noisy": "section 4.3.1",
    "for both controllers obtained the voltage does not exceed the maximum "
    "value of 7.4 V": "section 4.3.1",
    "The MIP is initialized in a position close to the equilibrium point": "section 4.3.1",
    "the position of the wheels for the PD controller varies a little, i.e., "
    "the MIP moves to keep the body in the balance position, unlike the PID, "
    "where the position of the wheels is maintained": "section 4.3.1",
    "This was expected since an integrator has been added": "section 4.3.1",
    "neither exceeds the maximum voltage of 7.4 V": "section 4.3.1",
    "all poles and zeros above or close to this frequency can generate random "
    "results, disturbing the discretization of the system": "section 4.3.2",
    "There was not a significant effect on noise suppression with the "
    "variation of R": "section 4.3.2",
    "both controllers limit the applied voltage to 3V, which is far from the "
    "7.4V limit": "section 4.3.2",
    "integral and acceleration gains bring no relevant drawback with respect "
    "to design complexity": "chapter 5",
    "the number of optimization variables is divided by four": "Appendix A, after (A.17)",
    "The choice of the U matrix in the examples in Chapter 3 and in the "
    "experiments in Chapter 4 was made randomly, taking into account only the "
    "controllability of the system": "chapter 5",
}
