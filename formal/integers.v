(* Matrices of integers that are computed, and what they mean in a field C. *)
From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra ssrZ zify.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* A matrix is a function of row and column; `memo` computes its entries once. *)
Definition entries := nat -> nat -> Z.

Definition at_ (rows : seq (seq Z)) : entries :=
  fun i j => nth Z0 (nth [::] rows i) j.
Definition memo n m (f : entries) : entries :=
  let rows := mkseq (fun i => mkseq (f i) m) n in at_ rows.
Definition sumZ k (f : nat -> Z) := foldr (fun i s => Z.add (f i) s) Z0 (iota 0 k).
Definition mul k (a b : entries) : entries :=
  fun i j => sumZ k (fun l => Z.mul (a i l) (b l j)).
Definition tr (a : entries) : entries := fun i j => a j i.

Section Meaning.
Variable C : numClosedFieldType.

Definition phi (z : Z) : C := (int_of_Z z)%:~R.

Lemma phi0 : phi Z0 = 0. Proof. by []. Qed.
Lemma phi1 : phi (Zpos xH) = 1. Proof. by []. Qed.
Lemma phiD a b : phi (Z.add a b) = phi a + phi b.
Proof. by rewrite /phi (raddfD ZInstances.int_of_Z_additive) rmorphD. Qed.
Lemma phiN a : phi (Z.opp a) = - phi a.
Proof. by rewrite /phi (raddfN ZInstances.int_of_Z_additive) rmorphN. Qed.
Lemma phiB a b : phi (Z.sub a b) = phi a - phi b.
Proof. by rewrite -Z.add_opp_r phiD phiN. Qed.
Lemma phiM a b : phi (Z.mul a b) = phi a * phi b.
Proof. by rewrite /phi (rmorphM ZInstances.int_of_Z_rmorphism) rmorphM. Qed.
Lemma phi_ge0 a : Z.leb 0 a -> 0 <= phi a.
Proof. by move=> h; rewrite /phi ler0z; lia. Qed.
Lemma phi_gt0 a : Z.ltb 0 a -> 0 < phi a.
Proof. by move=> h; rewrite /phi ltr0z; lia. Qed.
Lemma phi_lt0 a : Z.ltb a 0 -> phi a < 0.
Proof. by move=> h; rewrite /phi ltrz0; lia. Qed.
Lemma phi_conj a : (phi a)^* = phi a.
Proof. exact: rmorph_int. Qed.
Lemma phi_sum k f : phi (sumZ k f) = \sum_(i < k) phi (f i).
Proof.
rewrite -(big_mkord xpredT (fun i => phi (f i))) /index_iota subn0 /sumZ.
by elim: (iota 0 k) => [|i l IH]; rewrite ?big_nil // big_cons /= phiD IH.
Qed.

Definition mx n m (f : entries) : 'M[C]_(n, m) := \matrix_(i, j) phi (f i j).

Lemma memoE n m f i j : (i < n)%N -> (j < m)%N -> memo n m f i j = f i j.
Proof. by move=> h k; rewrite /memo /at_ nth_mkseq // nth_mkseq. Qed.
Lemma mx_memo n m f : mx n m (memo n m f) = mx n m f.
Proof. by apply/matrixP => i j; rewrite !mxE memoE. Qed.
Lemma mx_mul n k m a b : mx n m (mul k a b) = mx n k a *m mx k m b.
Proof.
apply/matrixP => i j; rewrite !mxE phi_sum.
by apply: eq_bigr => l _; rewrite !mxE phiM.
Qed.
Lemma mx_tr n m a : mx n m (tr a) = (mx m n a)^T.
Proof. by apply/matrixP => i j; rewrite !mxE. Qed.
End Meaning.
